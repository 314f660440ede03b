/* The model's equations applied to the numbers of an instance. */

#ifndef EQUATIONS_H
#define EQUATIONS_H

#include "instance.h"

void apply_initial(Data *data);
void apply_update(Data *data, double t);
void apply_outputs(Data *data);

/* Keep the inputs as those of the previous communication point. */
void remember_inputs(Data *data);

#endif

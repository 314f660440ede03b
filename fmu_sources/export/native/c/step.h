/* A communication step. */

#ifndef STEP_H
#define STEP_H

#include "instance.h"

/* Step from t to t + h [s]; what is refused changes nothing, a result that is not finite fails the instance. */
bool instance_step(Instance *instance, double t, double h);

#endif

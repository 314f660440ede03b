/* What values are allowed: the declared rules of parameters and inputs, finite results. */

#ifndef RULES_H
#define RULES_H

#include "instance.h"

/* Refuse parameters and inputs that break a rule; one message names all of them. */
bool check_rules(const Instance *instance, Data *data);

/* Refuse inputs that are not finite, and parameters that were set since the last check. */
RARE bool check_inputs(const Instance *instance, Data *data);

/* Refuse what the model calls a fault, and states and outputs that are not finite. */
RARE bool check_results(const Instance *instance, const Data *data);

/* Whether the model calls the present states a fault at t [s]. */
bool has_fault(const Data *data, double t);

/* Whether `check_inputs` and `check_results` would find nothing; false also where they have to look closely. */
bool are_inputs_well(const Data *data);
bool are_results_well(const Data *data);

#endif

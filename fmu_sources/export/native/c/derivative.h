/* Directional derivative of outputs and states with respect to parameters, inputs and states. */

#ifndef DERIVATIVE_H
#define DERIVATIVE_H

#include <stddef.h>

#include "instance.h"

typedef struct {
    const unsigned *references;
    size_t n;
} References;

/*
 * d(unknowns) = (d unknowns / d knowns) seed at the present point of time, states held. Outputs are
 * differentiated through the model's output equations; a state is its own derivative.
 */
bool directional_derivative(Instance *instance, References unknowns, References knowns, const double *seed,
                            double *sensitivity);

#endif

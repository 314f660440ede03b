#include "derivative.h"

bool directional_derivative(Instance *instance, References unknowns, References knowns, const double *seed,
                            double *sensitivity) {
    (void)unknowns, (void)knowns, (void)seed, (void)sensitivity;
    return refuse(instance, "directional derivative: not supported by a system exported as one FMU");
}

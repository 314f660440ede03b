/* A model's kernel without FMI: its equations and its integration, as fmi2DoStep runs them. */

#include "equations.h"
#include "instance.h"
#include "integrate.h"

void kernel_defaults(double *values) {
    for (int i = 0; i < N_VARIABLES; i++) {
        values[i] = model_variables[i].start;
    }
}

void kernel_start(Data *data, const double *values) {
    for (int i = 0; i < N_VARIABLES; i++) {
        data->values[i] = values[i];
    }
    data->time = 0.0;
    apply_initial(data);
    remember_inputs(data);
    apply_outputs(data);
}

void kernel_step(Data *data, double t, double h) {
    const double period = SAMPLE_TIME >= 0 ? data->values[PLACE(SAMPLE_TIME)] : h;
    if (N_STATES > N_CONTINUOUS) {
        apply_update(data, t);
    }
    if (N_CONTINUOUS > 0) {
        const int n = n_substeps(period);
        const Span span = {t, period / n, n, 0.0, 1.0};
        integrate(data, &span);
    }
    data->time = t + h;
    remember_inputs(data);
    apply_outputs(data);
}

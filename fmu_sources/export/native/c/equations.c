#include "equations.h"

#include <string.h>

typedef void StateEquations(double t, const double *x, const double *u, const double *p, double *new_x);

static void replace_states(StateEquations *equations, Data *data, double t) {
    double *x = data->values + FIRST_STATE;
    double new_x[ROOM(N_STATES)];
    equations(t, x, data->values + FIRST_INPUT, data->values, new_x);
    memcpy(x, new_x, N_STATES * sizeof *x);
}

void apply_initial(Data *data) {
    replace_states(model_initial, data, data->time);
}

void apply_update(Data *data, double t) {
    replace_states(model_update, data, t);
}

void apply_outputs(Data *data) {
    const double *values = data->values;
    model_outputs(data->time, values + FIRST_STATE, values + FIRST_INPUT, values,
                  data->values + FIRST_OUTPUT);
}

void remember_inputs(Data *data) {
    memcpy(data->previous_inputs, data->values + FIRST_INPUT, N_INPUTS * sizeof(double));
}

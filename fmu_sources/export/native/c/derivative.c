#include "derivative.h"

#include "access.h"

static const char FUNCTION[] = "directional derivative";

static bool collect_seed(const Instance *instance, References knowns, const double *seed,
                         double all[ROOM(FIRST_OUTPUT)]) {
    for (size_t i = 0; i < knowns.n; i++) {
        const unsigned reference = knowns.references[i];
        const Variable *variable = variable_at(instance, FUNCTION, reference);
        if (variable == NULL) {
            return false;
        }
        if (variable->role == ROLE_OUTPUT || variable->type != TYPE_REAL) {
            return refuse(instance, "%s: not a known, got %s, expected a real parameter, input or state",
                          FUNCTION, variable->name);
        }
        all[reference] += seed[i];
    }
    return true;
}

static bool check_unknowns(const Instance *instance, References unknowns) {
    for (size_t i = 0; i < unknowns.n; i++) {
        const Variable *variable = variable_at(instance, FUNCTION, unknowns.references[i]);
        if (variable == NULL) {
            return false;
        }
        if (variable->role == ROLE_PARAMETER || variable->role == ROLE_INPUT || variable->type != TYPE_REAL) {
            return refuse(instance, "%s: not an unknown, got %s, expected a real output or state", FUNCTION,
                          variable->name);
        }
    }
    return true;
}

bool directional_derivative(Instance *instance, References unknowns, References knowns, const double *seed,
                            double *sensitivity) {
    double all[ROOM(FIRST_OUTPUT)] = {0.0};
    double der_y[ROOM(N_OUTPUTS)];
    const Data *data = instance_readable(instance);
    if (data == NULL || !check_unknowns(instance, unknowns) || !collect_seed(instance, knowns, seed, all)) {
        return false;
    }
    const double *values = data->values;
    model_outputs_along(data->time, values + FIRST_STATE, values + FIRST_INPUT, values, all, der_y);
    for (size_t i = 0; i < unknowns.n; i++) {
        const unsigned reference = unknowns.references[i];
        sensitivity[i] = reference < FIRST_OUTPUT ? all[reference] : der_y[reference - FIRST_OUTPUT];
    }
    return true;
}

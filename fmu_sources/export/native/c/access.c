#include "access.h"

static const char *const TYPE_NAMES[] = {"real", "integer", "enumeration", "Boolean"};

const Variable *variable_at(const Instance *instance, const char *function, unsigned reference) {
    if (reference >= N_VARIABLES || model_variables[reference].is_hidden) {
        refuse(instance, "%s: value reference unknown, got %u, expected one of the model description", function,
               reference);
        return NULL;
    }
    return &model_variables[reference];
}

static const Variable *typed_variable(const Instance *instance, Access access, unsigned reference) {
    const Variable *variable = variable_at(instance, access.function, reference);
    if (variable != NULL && variable->type != access.type) {
        refuse(instance, "%s: variable of another type, got %s, which is of type %s, expected type %s",
               access.function, variable->name, TYPE_NAMES[variable->type], TYPE_NAMES[access.type]);
        return NULL;
    }
    return variable;
}

static bool is_result(const Variable *variable) {
    return variable->role == ROLE_STATE || variable->role == ROLE_OUTPUT;
}

bool read_any_value(Instance *instance, Access access, unsigned reference, double *value) {
    const Variable *variable = typed_variable(instance, access, reference);
    if (variable == NULL) {
        return false;
    }
    const Data *data = is_result(variable) ? instance_readable(instance) : &instance->now;
    if (data == NULL) {
        return false;
    }
    *value = data->values[reference];
    return true;
}

static bool check_writable(const Instance *instance, const char *function, const Variable *variable) {
    const bool is_running = instance->now.phase == STEPPING;
    if (variable->role == ROLE_OUTPUT) {
        return refuse(instance, "%s: not settable, got %s, which is an output", function, variable->name);
    }
    if (is_running && (variable->is_fixed || variable->role == ROLE_STATE)) {
        return refuse(instance, "%s: call not allowed now, got %s, expected it before the first step", function,
                      variable->name);
    }
    return true;
}

bool write_any_value(Instance *instance, Access access, unsigned reference, double value) {
    const Variable *variable = typed_variable(instance, access, reference);
    if (variable == NULL || !check_writable(instance, access.function, variable)) {
        return false;
    }
    instance->now.values[reference] = value;
    instance->is_preview_valid = false;
    if (variable->role == ROLE_PARAMETER) {
        instance->now.is_unchecked = 1;
    }
    return true;
}

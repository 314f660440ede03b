/* FMI 2.0: getting and setting variables. */

#include <limits.h>

#include "fmi2Functions.h"

#include "access.h"
#include "lifecycle.h"

static bool is_call_allowed(const Instance *instance, const char *function, int phases, size_t n,
                            const void *references, const void *values) {
    return instance != NULL && allow(instance, function, phases) &&
           check_arrays(instance, function, n, references, values);
}

static RARE fmi2Status get_reals(fmi2Component c, const fmi2ValueReference vr[], size_t n, fmi2Real values[]) {
    const Access access = {"fmi2GetReal", TYPE_REAL};
    bool is_ok = is_call_allowed(c, access.function, READABLE, n, vr, values);
    for (size_t i = 0; is_ok && i < n; i++) {
        is_ok = read_any_value(c, access, vr[i], &values[i]);
    }
    return is_ok ? fmi2OK : fmi2Error;
}

static RARE fmi2Status set_reals(fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2Real values[]) {
    const Access access = {"fmi2SetReal", TYPE_REAL};
    bool is_ok = is_call_allowed(c, access.function, WRITABLE, n, vr, values);
    for (size_t i = 0; is_ok && i < n; i++) {
        is_ok = write_any_value(c, access, vr[i], values[i]);
    }
    return is_ok ? fmi2OK : fmi2Error;
}

fmi2Status fmi2GetReal(fmi2Component c, const fmi2ValueReference vr[], size_t n, fmi2Real values[]) {
    return read_usual(c, TYPE_REAL, vr, n, values) ? fmi2OK : get_reals(c, vr, n, values);
}

fmi2Status fmi2SetReal(fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2Real values[]) {
    return write_usual(c, TYPE_REAL, vr, n, values) ? fmi2OK : set_reals(c, vr, n, values);
}

/* FMI 2.0 has one pair of functions for integers and enumerations. */
static Access integer_access(const char *function, fmi2ValueReference reference) {
    const bool is_enumeration =
        reference < N_VARIABLES && model_variables[reference].type == TYPE_ENUMERATION;
    return (Access){function, is_enumeration ? TYPE_ENUMERATION : TYPE_INTEGER};
}

fmi2Status fmi2GetInteger(fmi2Component c, const fmi2ValueReference vr[], size_t n, fmi2Integer values[]) {
    static const char function[] = "fmi2GetInteger";
    bool is_ok = is_call_allowed(c, function, READABLE, n, vr, values);
    for (size_t i = 0; is_ok && i < n; i++) {
        double value = 0.0;
        is_ok = read_value(c, integer_access(function, vr[i]), vr[i], &value);
        values[i] = value > INT_MIN && value < INT_MAX ? (fmi2Integer)value : 0;
    }
    return is_ok ? fmi2OK : fmi2Error;
}

fmi2Status fmi2SetInteger(fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2Integer values[]) {
    static const char function[] = "fmi2SetInteger";
    bool is_ok = is_call_allowed(c, function, WRITABLE, n, vr, values);
    for (size_t i = 0; is_ok && i < n; i++) {
        is_ok = write_value(c, integer_access(function, vr[i]), vr[i], values[i]);
    }
    return is_ok ? fmi2OK : fmi2Error;
}

fmi2Status fmi2GetBoolean(fmi2Component c, const fmi2ValueReference vr[], size_t n, fmi2Boolean values[]) {
    const Access access = {"fmi2GetBoolean", TYPE_BOOLEAN};
    bool is_ok = is_call_allowed(c, access.function, READABLE, n, vr, values);
    for (size_t i = 0; is_ok && i < n; i++) {
        double value = 0.0;
        is_ok = read_value(c, access, vr[i], &value);
        values[i] = value != 0.0 ? fmi2True : fmi2False;
    }
    return is_ok ? fmi2OK : fmi2Error;
}

fmi2Status fmi2SetBoolean(fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2Boolean values[]) {
    const Access access = {"fmi2SetBoolean", TYPE_BOOLEAN};
    bool is_ok = is_call_allowed(c, access.function, WRITABLE, n, vr, values);
    for (size_t i = 0; is_ok && i < n; i++) {
        is_ok = write_value(c, access, vr[i], values[i] != fmi2False ? 1.0 : 0.0);
    }
    return is_ok ? fmi2OK : fmi2Error;
}

/* FMI 3.0: getting and setting variables; time is the variable behind the last one of the model. */

#include "fmi3Functions.h"

#include "access.h"
#include "lifecycle.h"

enum { TIME_REFERENCE = N_VARIABLES };

typedef struct {
    const fmi3ValueReference *references;
    size_t n;
    const void *values;
    size_t n_values;
} Arrays;

static bool is_call_allowed(const Instance *instance, const char *function, int phases, Arrays arrays) {
    return instance != NULL && allow(instance, function, phases) &&
           check_lengths(instance, function, arrays.n, arrays.n_values) &&
           check_arrays(instance, function, arrays.n, arrays.references, arrays.values);
}

static bool read_real(Instance *instance, Access access, unsigned reference, double *value) {
    if (reference == TIME_REFERENCE) {
        *value = instance->now.time;
        return true;
    }
    return read_any_value(instance, access, reference, value);
}

static RARE fmi3Status get_reals(Instance *c, Arrays arrays, double *values) {
    const Access access = {"fmi3GetFloat64", TYPE_REAL};
    bool is_ok = is_call_allowed(c, access.function, READABLE, arrays);
    for (size_t i = 0; is_ok && i < arrays.n; i++) {
        is_ok = read_real(c, access, arrays.references[i], &values[i]);
    }
    return is_ok ? fmi3OK : fmi3Error;
}

static RARE fmi3Status set_reals(Instance *c, Arrays arrays, const double *values) {
    const Access access = {"fmi3SetFloat64", TYPE_REAL};
    bool is_ok = is_call_allowed(c, access.function, WRITABLE, arrays);
    for (size_t i = 0; is_ok && i < arrays.n; i++) {
        is_ok = write_any_value(c, access, arrays.references[i], values[i]);
    }
    return is_ok ? fmi3OK : fmi3Error;
}

fmi3Status fmi3GetFloat64(fmi3Instance c, const fmi3ValueReference vr[], size_t n, fmi3Float64 values[],
                          size_t n_values) {
    const bool is_usual = n == n_values && read_usual(c, TYPE_REAL, vr, n, values);
    return is_usual ? fmi3OK : get_reals(c, (Arrays){vr, n, values, n_values}, values);
}

fmi3Status fmi3SetFloat64(fmi3Instance c, const fmi3ValueReference vr[], size_t n, const fmi3Float64 values[],
                          size_t n_values) {
    const bool is_usual = n == n_values && write_usual(c, TYPE_REAL, vr, n, values);
    return is_usual ? fmi3OK : set_reals(c, (Arrays){vr, n, values, n_values}, values);
}

fmi3Status fmi3GetInt32(fmi3Instance c, const fmi3ValueReference vr[], size_t n, fmi3Int32 values[],
                        size_t n_values) {
    const Access access = {"fmi3GetInt32", TYPE_INTEGER};
    bool is_ok = is_call_allowed(c, access.function, READABLE, (Arrays){vr, n, values, n_values});
    for (size_t i = 0; is_ok && i < n; i++) {
        double value = 0.0;
        is_ok = read_value(c, access, vr[i], &value);
        values[i] = value > INT32_MIN && value < INT32_MAX ? (fmi3Int32)value : 0;
    }
    return is_ok ? fmi3OK : fmi3Error;
}

fmi3Status fmi3SetInt32(fmi3Instance c, const fmi3ValueReference vr[], size_t n, const fmi3Int32 values[],
                        size_t n_values) {
    const Access access = {"fmi3SetInt32", TYPE_INTEGER};
    bool is_ok = is_call_allowed(c, access.function, WRITABLE, (Arrays){vr, n, values, n_values});
    for (size_t i = 0; is_ok && i < n; i++) {
        is_ok = write_value(c, access, vr[i], values[i]);
    }
    return is_ok ? fmi3OK : fmi3Error;
}

fmi3Status fmi3GetInt64(fmi3Instance c, const fmi3ValueReference vr[], size_t n, fmi3Int64 values[],
                        size_t n_values) {
    const Access access = {"fmi3GetInt64", TYPE_ENUMERATION};
    bool is_ok = is_call_allowed(c, access.function, READABLE, (Arrays){vr, n, values, n_values});
    for (size_t i = 0; is_ok && i < n; i++) {
        double value = 0.0;
        is_ok = read_value(c, access, vr[i], &value);
        values[i] = value > -1e15 && value < 1e15 ? (fmi3Int64)value : 0;
    }
    return is_ok ? fmi3OK : fmi3Error;
}

fmi3Status fmi3SetInt64(fmi3Instance c, const fmi3ValueReference vr[], size_t n, const fmi3Int64 values[],
                        size_t n_values) {
    const Access access = {"fmi3SetInt64", TYPE_ENUMERATION};
    bool is_ok = is_call_allowed(c, access.function, WRITABLE, (Arrays){vr, n, values, n_values});
    for (size_t i = 0; is_ok && i < n; i++) {
        is_ok = write_value(c, access, vr[i], (double)values[i]);
    }
    return is_ok ? fmi3OK : fmi3Error;
}

fmi3Status fmi3GetBoolean(fmi3Instance c, const fmi3ValueReference vr[], size_t n, fmi3Boolean values[],
                          size_t n_values) {
    const Access access = {"fmi3GetBoolean", TYPE_BOOLEAN};
    bool is_ok = is_call_allowed(c, access.function, READABLE, (Arrays){vr, n, values, n_values});
    for (size_t i = 0; is_ok && i < n; i++) {
        double value = 0.0;
        is_ok = read_value(c, access, vr[i], &value);
        values[i] = value != 0.0;
    }
    return is_ok ? fmi3OK : fmi3Error;
}

fmi3Status fmi3SetBoolean(fmi3Instance c, const fmi3ValueReference vr[], size_t n, const fmi3Boolean values[],
                          size_t n_values) {
    const Access access = {"fmi3SetBoolean", TYPE_BOOLEAN};
    bool is_ok = is_call_allowed(c, access.function, WRITABLE, (Arrays){vr, n, values, n_values});
    for (size_t i = 0; is_ok && i < n; i++) {
        is_ok = write_value(c, access, vr[i], values[i] ? 1.0 : 0.0);
    }
    return is_ok ? fmi3OK : fmi3Error;
}

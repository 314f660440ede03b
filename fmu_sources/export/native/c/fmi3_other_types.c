/* FMI 3.0: types of which this FMU has no variable; a call for none of them is allowed. */

#include "fmi3Functions.h"

#include "instance.h"

static fmi3Status of_none(const Instance *instance, const char *function, size_t n) {
    if (instance == NULL) {
        return fmi3Error;
    }
    if (n > 0) {
        refuse(instance, "%s: type not known, expected Float64, Int32, Int64 or Boolean", function);
    }
    return n > 0 ? fmi3Error : fmi3OK;
}

#define NO_VARIABLES(TYPE)                                                                                \
    fmi3Status fmi3Get##TYPE(fmi3Instance c, const fmi3ValueReference vr[], size_t n, fmi3##TYPE values[], \
                             size_t n_values) {                                                            \
        (void)vr, (void)values, (void)n_values;                                                            \
        return of_none(c, "fmi3Get" #TYPE, n);                                                             \
    }                                                                                                      \
    fmi3Status fmi3Set##TYPE(fmi3Instance c, const fmi3ValueReference vr[], size_t n,                      \
                             const fmi3##TYPE values[], size_t n_values) {                                 \
        (void)vr, (void)values, (void)n_values;                                                            \
        return of_none(c, "fmi3Set" #TYPE, n);                                                             \
    }

NO_VARIABLES(Float32)
NO_VARIABLES(Int8)
NO_VARIABLES(UInt8)
NO_VARIABLES(Int16)
NO_VARIABLES(UInt16)
NO_VARIABLES(UInt32)
NO_VARIABLES(UInt64)
NO_VARIABLES(String)

fmi3Status fmi3GetBinary(fmi3Instance c, const fmi3ValueReference vr[], size_t n, size_t sizes[],
                         fmi3Binary values[], size_t n_values) {
    (void)vr, (void)sizes, (void)values, (void)n_values;
    return of_none(c, "fmi3GetBinary", n);
}

fmi3Status fmi3SetBinary(fmi3Instance c, const fmi3ValueReference vr[], size_t n, const size_t sizes[],
                         const fmi3Binary values[], size_t n_values) {
    (void)vr, (void)sizes, (void)values, (void)n_values;
    return of_none(c, "fmi3SetBinary", n);
}

fmi3Status fmi3GetClock(fmi3Instance c, const fmi3ValueReference vr[], size_t n, fmi3Clock values[]) {
    (void)vr, (void)values;
    return of_none(c, "fmi3GetClock", n);
}

fmi3Status fmi3SetClock(fmi3Instance c, const fmi3ValueReference vr[], size_t n, const fmi3Clock values[]) {
    (void)vr, (void)values;
    return of_none(c, "fmi3SetClock", n);
}

/* FMI 2.0: what this FMU has not, with a message for whoever calls it. */

#include "fmi2Functions.h"

#include "instance.h"

static fmi2Status unsupported(const Instance *instance, const char *function, const char *what) {
    if (instance != NULL) {
        refuse(instance, "%s: not supported, the FMU has no %s", function, what);
    }
    return fmi2Error;
}

static fmi2Status of_none(const Instance *instance, const char *function, size_t n, const char *what) {
    return instance != NULL && n == 0 ? fmi2OK : unsupported(instance, function, what);
}

fmi2Status fmi2GetString(fmi2Component c, const fmi2ValueReference vr[], size_t n, fmi2String values[]) {
    (void)vr, (void)values;
    return of_none(c, "fmi2GetString", n, "variable of type String");
}

fmi2Status fmi2SetString(fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2String values[]) {
    (void)vr, (void)values;
    return of_none(c, "fmi2SetString", n, "variable of type String");
}

fmi2Status fmi2SetRealInputDerivatives(fmi2Component c, const fmi2ValueReference vr[], size_t n,
                                       const fmi2Integer order[], const fmi2Real values[]) {
    (void)vr, (void)order, (void)values;
    return of_none(c, "fmi2SetRealInputDerivatives", n, "input derivatives");
}

fmi2Status fmi2GetRealOutputDerivatives(fmi2Component c, const fmi2ValueReference vr[], size_t n,
                                        const fmi2Integer order[], fmi2Real values[]) {
    (void)vr, (void)order, (void)values;
    return of_none(c, "fmi2GetRealOutputDerivatives", n, "output derivatives");
}

fmi2Status fmi2CancelStep(fmi2Component c) {
    return unsupported(c, "fmi2CancelStep", "step that runs beside the caller");
}

fmi2Status fmi2GetStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Status *value) {
    (void)kind, (void)value;
    return unsupported(c, "fmi2GetStatus", "step that runs beside the caller");
}

fmi2Status fmi2GetRealStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Real *value) {
    if (c == NULL || kind != fmi2LastSuccessfulTime || value == NULL) {
        return unsupported(c, "fmi2GetRealStatus", "such status");
    }
    *value = ((const Instance *)c)->now.time;
    return fmi2OK;
}

fmi2Status fmi2GetIntegerStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Integer *value) {
    (void)kind, (void)value;
    return unsupported(c, "fmi2GetIntegerStatus", "such status");
}

fmi2Status fmi2GetBooleanStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Boolean *value) {
    if (c == NULL || kind != fmi2Terminated || value == NULL) {
        return unsupported(c, "fmi2GetBooleanStatus", "such status");
    }
    *value = fmi2False;
    return fmi2OK;
}

fmi2Status fmi2GetStringStatus(fmi2Component c, const fmi2StatusKind kind, fmi2String *value) {
    (void)kind, (void)value;
    return unsupported(c, "fmi2GetStringStatus", "step that runs beside the caller");
}

/* FMI 2.0 for co-simulation on the instance. */

#include "fmi2Functions.h"

#include "access.h"
#include "derivative.h"
#include "lifecycle.h"
#include "saved_state.h"
#include "step.h"
#include "text.h"

static const char CATEGORY[] = "logStatusError";

static fmi2Status status_of(bool is_ok) {
    return is_ok ? fmi2OK : fmi2Error;
}

/* The message is the format itself: hosts written in Python cannot read the arguments behind it. */
static void say(fmi2CallbackLogger logger, fmi2ComponentEnvironment environment, const char *name,
                const char *message) {
    if (logger != NULL) {
        Text format = {.length = 0};
        text_append_format(&format, message);
        logger(environment, name, fmi2Error, CATEGORY, format.at);
    }
}

static void log_error(const Instance *instance, const char *message) {
    say((fmi2CallbackLogger)instance->callback, instance->environment, instance->name, message);
}

const char *fmi2GetTypesPlatform(void) {
    return fmi2TypesPlatform;
}

const char *fmi2GetVersion(void) {
    return fmi2Version;
}

fmi2Status fmi2SetDebugLogging(fmi2Component c, fmi2Boolean is_on, size_t n, const fmi2String categories[]) {
    (void)is_on; /* only errors are logged, and these always */
    return status_of(c != NULL && check_arrays(c, "fmi2SetDebugLogging", n, categories, categories));
}

fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String guid, fmi2String resources,
                              const fmi2CallbackFunctions *functions, fmi2Boolean visible,
                              fmi2Boolean is_logging_on) {
    (void)resources, (void)visible, (void)is_logging_on;
    if (functions == NULL) {
        return NULL;
    }
    const char *problem = instantiation_problem(name, guid);
    if (type != fmi2CoSimulation) {
        problem = "FMU type: got model exchange, expected co-simulation";
    }
    Instance *instance = problem == NULL ? instance_create(name) : NULL;
    if (instance == NULL) {
        say(functions->logger, functions->componentEnvironment, name != NULL ? name : "",
            problem != NULL ? problem : "out of memory");
        return NULL;
    }
    instance->environment = functions->componentEnvironment;
    instance->callback = (void (*)(void))functions->logger;
    instance->log = log_error;
    return instance;
}

void fmi2FreeInstance(fmi2Component c) {
    instance_free(c);
}

fmi2Status fmi2SetupExperiment(fmi2Component c, fmi2Boolean has_tolerance, fmi2Real tolerance, fmi2Real start_time,
                               fmi2Boolean has_stop_time, fmi2Real stop_time) {
    (void)has_tolerance, (void)tolerance, (void)has_stop_time, (void)stop_time;
    Instance *instance = c;
    if (instance == NULL || !allow(instance, "fmi2SetupExperiment", INSTANTIATED)) {
        return fmi2Error;
    }
    instance->now.time = start_time;
    return fmi2OK;
}

fmi2Status fmi2EnterInitializationMode(fmi2Component c) {
    Instance *instance = c;
    return status_of(c != NULL &&
                     enter_initialisation(instance, "fmi2EnterInitializationMode", instance->now.time));
}

fmi2Status fmi2ExitInitializationMode(fmi2Component c) {
    return status_of(c != NULL && exit_initialisation(c, "fmi2ExitInitializationMode"));
}

fmi2Status fmi2Terminate(fmi2Component c) {
    return status_of(c != NULL && terminate(c, "fmi2Terminate"));
}

fmi2Status fmi2Reset(fmi2Component c) {
    if (c != NULL) {
        instance_reset(c);
    }
    return status_of(c != NULL);
}

fmi2Status fmi2GetFMUstate(fmi2Component c, fmi2FMUstate *state) {
    return status_of(c != NULL && save_state(c, state));
}

fmi2Status fmi2SetFMUstate(fmi2Component c, fmi2FMUstate state) {
    return status_of(c != NULL && restore_state(c, state));
}

fmi2Status fmi2FreeFMUstate(fmi2Component c, fmi2FMUstate *state) {
    free_state(state);
    return status_of(c != NULL);
}

fmi2Status fmi2SerializedFMUstateSize(fmi2Component c, fmi2FMUstate state, size_t *size) {
    (void)state;
    if (c == NULL || !check_arrays(c, "fmi2SerializedFMUstateSize", 1, size, size)) {
        return fmi2Error;
    }
    *size = serialised_size();
    return fmi2OK;
}

fmi2Status fmi2SerializeFMUstate(fmi2Component c, fmi2FMUstate state, fmi2Byte bytes[], size_t size) {
    return status_of(c != NULL && serialise_state(c, state, bytes, size));
}

fmi2Status fmi2DeSerializeFMUstate(fmi2Component c, const fmi2Byte bytes[], size_t size, fmi2FMUstate *state) {
    return status_of(c != NULL && deserialise_state(c, bytes, size, state));
}

fmi2Status fmi2GetDirectionalDerivative(fmi2Component c, const fmi2ValueReference unknowns[], size_t n_unknowns,
                                        const fmi2ValueReference knowns[], size_t n_knowns,
                                        const fmi2Real seed[], fmi2Real sensitivity[]) {
    static const char function[] = "fmi2GetDirectionalDerivative";
    const References rows = {unknowns, n_unknowns}, columns = {knowns, n_knowns};
    return status_of(c != NULL && allow(c, function, READABLE) &&
                     check_arrays(c, function, n_unknowns, unknowns, sensitivity) &&
                     check_arrays(c, function, n_knowns, knowns, seed) &&
                     directional_derivative(c, rows, columns, seed, sensitivity));
}

fmi2Status fmi2DoStep(fmi2Component c, fmi2Real t, fmi2Real h, fmi2Boolean never_goes_back) {
    (void)never_goes_back;
    return status_of(c != NULL && allow(c, "fmi2DoStep", STEPPING) && instance_step(c, t, h));
}

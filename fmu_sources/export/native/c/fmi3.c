/* FMI 3.0 for co-simulation on the instance. */

#include "fmi3Functions.h"

#include "access.h"
#include "derivative.h"
#include "lifecycle.h"
#include "saved_state.h"
#include "step.h"

static const char CATEGORY[] = "logStatusError";

static fmi3Status status_of(bool is_ok) {
    return is_ok ? fmi3OK : fmi3Error;
}

static void log_error(const Instance *instance, const char *message) {
    const fmi3LogMessageCallback logger = (fmi3LogMessageCallback)instance->callback;
    if (logger != NULL) {
        logger(instance->environment, fmi3Error, CATEGORY, message);
    }
}

static fmi3Instance refuse_instance(fmi3LogMessageCallback logger, fmi3InstanceEnvironment environment,
                                    const char *message) {
    if (logger != NULL) {
        logger(environment, fmi3Error, CATEGORY, message);
    }
    return NULL;
}

const char *fmi3GetVersion(void) {
    return fmi3Version;
}

fmi3Status fmi3SetDebugLogging(fmi3Instance c, fmi3Boolean is_on, size_t n, const fmi3String categories[]) {
    (void)is_on; /* only errors are logged, and these always */
    return status_of(c != NULL && check_arrays(c, "fmi3SetDebugLogging", n, categories, categories));
}

fmi3Instance fmi3InstantiateCoSimulation(fmi3String name, fmi3String token, fmi3String resources,
                                         fmi3Boolean visible, fmi3Boolean is_logging_on,
                                         fmi3Boolean has_events, fmi3Boolean may_return_early,
                                         const fmi3ValueReference intermediate[], size_t n_intermediate,
                                         fmi3InstanceEnvironment environment, fmi3LogMessageCallback logger,
                                         fmi3IntermediateUpdateCallback update) {
    (void)resources, (void)visible, (void)is_logging_on, (void)may_return_early, (void)intermediate, (void)update;
    const char *problem = instantiation_problem(name, token);
    if (has_events || n_intermediate > 0) {
        problem = "fmi3InstantiateCoSimulation: got event mode or intermediate variables, expected neither";
    }
    if (problem != NULL) {
        return refuse_instance(logger, environment, problem);
    }
    Instance *instance = instance_create(name);
    if (instance == NULL) {
        return refuse_instance(logger, environment, "out of memory");
    }
    instance->environment = environment;
    instance->callback = (void (*)(void))logger;
    instance->log = log_error;
    return instance;
}

fmi3Instance fmi3InstantiateModelExchange(fmi3String name, fmi3String token, fmi3String resources,
                                          fmi3Boolean visible, fmi3Boolean is_logging_on,
                                          fmi3InstanceEnvironment environment, fmi3LogMessageCallback logger) {
    (void)name, (void)token, (void)resources, (void)visible, (void)is_logging_on;
    return refuse_instance(logger, environment, "FMU type: got model exchange, expected co-simulation");
}

fmi3Instance fmi3InstantiateScheduledExecution(fmi3String name, fmi3String token, fmi3String resources,
                                               fmi3Boolean visible, fmi3Boolean is_logging_on,
                                               fmi3InstanceEnvironment environment,
                                               fmi3LogMessageCallback logger, fmi3ClockUpdateCallback update,
                                               fmi3LockPreemptionCallback lock,
                                               fmi3UnlockPreemptionCallback unlock) {
    (void)name, (void)token, (void)resources, (void)visible, (void)is_logging_on;
    (void)update, (void)lock, (void)unlock;
    return refuse_instance(logger, environment, "FMU type: got scheduled execution, expected co-simulation");
}

void fmi3FreeInstance(fmi3Instance c) {
    instance_free(c);
}

fmi3Status fmi3EnterInitializationMode(fmi3Instance c, fmi3Boolean has_tolerance, fmi3Float64 tolerance,
                                       fmi3Float64 start_time, fmi3Boolean has_stop_time,
                                       fmi3Float64 stop_time) {
    (void)has_tolerance, (void)tolerance, (void)has_stop_time, (void)stop_time;
    return status_of(c != NULL && enter_initialisation(c, "fmi3EnterInitializationMode", start_time));
}

fmi3Status fmi3ExitInitializationMode(fmi3Instance c) {
    return status_of(c != NULL && exit_initialisation(c, "fmi3ExitInitializationMode"));
}

fmi3Status fmi3Terminate(fmi3Instance c) {
    return status_of(c != NULL && terminate(c, "fmi3Terminate"));
}

fmi3Status fmi3Reset(fmi3Instance c) {
    if (c != NULL) {
        instance_reset(c);
    }
    return status_of(c != NULL);
}

fmi3Status fmi3GetFMUState(fmi3Instance c, fmi3FMUState *state) {
    return status_of(c != NULL && save_state(c, state));
}

fmi3Status fmi3SetFMUState(fmi3Instance c, fmi3FMUState state) {
    return status_of(c != NULL && restore_state(c, state));
}

fmi3Status fmi3FreeFMUState(fmi3Instance c, fmi3FMUState *state) {
    free_state(state);
    return status_of(c != NULL);
}

fmi3Status fmi3SerializedFMUStateSize(fmi3Instance c, fmi3FMUState state, size_t *size) {
    (void)state;
    if (c == NULL || !check_arrays(c, "fmi3SerializedFMUStateSize", 1, size, size)) {
        return fmi3Error;
    }
    *size = serialised_size();
    return fmi3OK;
}

fmi3Status fmi3SerializeFMUState(fmi3Instance c, fmi3FMUState state, fmi3Byte bytes[], size_t size) {
    return status_of(c != NULL && serialise_state(c, state, bytes, size));
}

fmi3Status fmi3DeserializeFMUState(fmi3Instance c, const fmi3Byte bytes[], size_t size, fmi3FMUState *state) {
    return status_of(c != NULL && deserialise_state(c, bytes, size, state));
}

fmi3Status fmi3GetDirectionalDerivative(fmi3Instance c, const fmi3ValueReference unknowns[], size_t n_unknowns,
                                        const fmi3ValueReference knowns[], size_t n_knowns,
                                        const fmi3Float64 seed[], size_t n_seed, fmi3Float64 sensitivity[],
                                        size_t n_sensitivity) {
    static const char function[] = "fmi3GetDirectionalDerivative";
    const References rows = {unknowns, n_unknowns}, columns = {knowns, n_knowns};
    return status_of(c != NULL && allow(c, function, READABLE) &&
                     check_lengths(c, function, n_unknowns, n_sensitivity) &&
                     check_lengths(c, function, n_knowns, n_seed) &&
                     check_arrays(c, function, n_unknowns, unknowns, sensitivity) &&
                     check_arrays(c, function, n_knowns, knowns, seed) &&
                     directional_derivative(c, rows, columns, seed, sensitivity));
}

fmi3Status fmi3DoStep(fmi3Instance c, fmi3Float64 t, fmi3Float64 h, fmi3Boolean never_goes_back,
                      fmi3Boolean *needs_event, fmi3Boolean *wants_end, fmi3Boolean *returned_early,
                      fmi3Float64 *last_time) {
    (void)never_goes_back;
    Instance *instance = c;
    const bool has_room = needs_event != NULL && wants_end != NULL && returned_early != NULL && last_time != NULL;
    if (instance == NULL || !check_arrays(instance, "fmi3DoStep", has_room ? 0 : 1, NULL, NULL) ||
        !allow(instance, "fmi3DoStep", STEPPING)) {
        return fmi3Error;
    }
    *needs_event = *wants_end = *returned_early = fmi3False;
    const bool is_ok = instance_step(instance, t, h);
    *last_time = is_ok ? instance->now.time : t;
    return status_of(is_ok);
}

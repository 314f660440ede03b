/* Random sequences of FMI calls, legal and illegal, with memory-safe arguments; FMI 2.0 and FMI 3.0, in threads. */

#include <math.h>
#include <pthread.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "fmi2Functions.h"
#include "fmi3Functions.h"
#include "model.h"

enum { MOST = 6, CALLS = 120 };

static _Thread_local uint64_t seed;

static unsigned draw(unsigned n) {
    seed = seed * 6364136223846793005u + 1442695040888963407u;
    return (unsigned)(seed >> 33) % n;
}

static double number(void) {
    static const double odd[] = {0.0, -1.0, 1e-3, 1e300, -1e300, NAN, INFINITY, -INFINITY, 1.0, 5e-324};
    return draw(3) == 0 ? odd[draw(10)] : (draw(2001) - 1000.0) * 1e-3;
}

static void check_status(int status) {
    if (status != fmi2OK && status != fmi2Error) {
        printf("unexpected status %d\n", status);
        exit(2);
    }
}

static _Thread_local int n_messages, n_steps;

static void logger2(fmi2ComponentEnvironment e, fmi2String name, fmi2Status s, fmi2String category,
                    fmi2String message, ...) {
    (void)e, (void)s, (void)category;
    n_messages += name != NULL && message != NULL;
}

static void logger3(fmi3InstanceEnvironment e, fmi3Status s, fmi3String category, fmi3String message) {
    (void)e, (void)s, (void)category;
    n_messages += strlen(message) > 0;
}

typedef struct {
    unsigned references[MOST];
    double reals[MOST];
    int integers[MOST];
    int64_t longs[MOST];
    bool flags[MOST];
    size_t n;
} Arguments;

static Arguments arguments(void) {
    Arguments a = {.n = draw(MOST)};
    for (size_t i = 0; i < MOST; i++) {
        a.references[i] = draw(20) == 0 ? draw(4000000000u) : draw(N_VARIABLES + 2);
        a.reals[i] = number();
        a.integers[i] = (int)draw(7) - 2;
        a.longs[i] = draw(9) == 0 ? INT64_MIN : (int)draw(7) - 2;
        a.flags[i] = draw(2);
    }
    return a;
}

/* A step that the model takes as long as nobody has changed its parameters. */
static double good_step(void) {
    return SAMPLE_TIME < 0 ? 1e-3 : model_variables[PLACE(SAMPLE_TIME)].start;
}

static double some_step(void) {
    static const double good_steps[] = {1.0, 2.0, 1.0, 0.0, -1.0, NAN, INFINITY, 1.7};
    return good_steps[draw(8)] * good_step();
}

static int state_call2(fmi2Component c, fmi2FMUstate *state) {
    static _Thread_local char bytes[100000];
    size_t size = 0;
    switch (draw(6)) {
    case 0:
        return fmi2SetFMUstate(c, *state);
    case 1:
        return fmi2FreeFMUstate(c, draw(5) ? state : NULL);
    case 2:
        fmi2SerializedFMUstateSize(c, *state, &size);
        fmi2SerializeFMUstate(c, *state, bytes, draw(3) ? size : draw(100));
        bytes[draw(draw(10) ? 1000 : 1) + 40] ^= draw(4) ? 0 : (char)draw(256);
        return fmi2DeSerializeFMUstate(c, bytes, draw(5) ? size : draw(100), state);
    default:
        return fmi2GetFMUstate(c, draw(9) ? state : NULL);
    }
}

static int value_call2(fmi2Component c) {
    Arguments a = arguments();
    const unsigned *vr = draw(20) ? a.references : NULL;
    switch (draw(9)) {
    case 0:
        return fmi2SetReal(c, vr, a.n, a.reals);
    case 1:
        return fmi2SetInteger(c, vr, a.n, a.integers);
    case 2:
        return fmi2SetBoolean(c, vr, a.n, a.integers);
    case 3:
        return fmi2GetReal(c, vr, a.n, draw(20) ? a.reals : NULL);
    case 4:
        return fmi2GetInteger(c, vr, a.n, a.integers);
    case 5:
        return fmi2GetBoolean(c, vr, a.n, a.integers);
    case 6:
        return fmi2GetString(c, vr, a.n, NULL);
    case 7:
        return fmi2SetRealInputDerivatives(c, vr, a.n, a.integers, a.reals);
    default:
        return fmi2GetDirectionalDerivative(c, vr, a.n, a.references, draw(MOST), a.reals, a.reals);
    }
}

static void run2(void) {
    const fmi2CallbackFunctions callbacks = {draw(9) ? logger2 : NULL, calloc, free, NULL, NULL};
    fmi2Component c = fmi2Instantiate("fuzz", fmi2CoSimulation, draw(20) ? MODEL_GUID : "x", NULL, &callbacks, 0, 0);
    fmi2FMUstate state = NULL;
    fmi2Real t = 0.0;
    for (int k = 0; k < CALLS; k++) {
        const double h = some_step();
        int status = fmi2OK;
        switch (draw(12)) {
        case 0:
            status = fmi2SetupExperiment(c, 0, 0.0, draw(9) ? 0.0 : number(), 0, number());
            break;
        case 1:
            status = fmi2EnterInitializationMode(c);
            break;
        case 2:
            status = fmi2ExitInitializationMode(c);
            break;
        case 3:
            status = draw(8) ? fmi2OK : fmi2Terminate(c);
            break;
        case 4:
            status = draw(8) ? fmi2OK : fmi2Reset(c);
            break;
        case 5:
            status = state_call2(c, &state);
            break;
        case 6:
            status = fmi2CancelStep(c);
            break;
        case 7:
            fmi2GetRealStatus(c, fmi2LastSuccessfulTime, &t);
            status = fmi2DoStep(c, draw(9) ? t : number(), h, draw(2));
            break;
        case 8:
            fmi2GetRealStatus(c, fmi2LastSuccessfulTime, &t);
            status = fmi2DoStep(c, t, good_step(), 1);
            n_steps += status == fmi2OK;
            break;
        default:
            status = value_call2(c);
        }
        check_status(status);
    }
    fmi2FreeFMUstate(c, &state);
    fmi2FreeInstance(c);
}

static int value_call3(fmi3Instance c) {
    Arguments a = arguments();
    const unsigned *vr = draw(20) ? a.references : NULL;
    const size_t n = draw(20) ? a.n : draw(MOST);
    switch (draw(12)) {
    case 0:
        return fmi3SetFloat64(c, vr, a.n, a.reals, n);
    case 1:
        return fmi3SetInt32(c, vr, a.n, a.integers, n);
    case 2:
        return fmi3SetInt64(c, vr, a.n, a.longs, n);
    case 3:
        return fmi3SetBoolean(c, vr, a.n, a.flags, n);
    case 4:
        return fmi3GetFloat64(c, vr, a.n, draw(20) ? a.reals : NULL, n);
    case 5:
        return fmi3GetInt32(c, vr, a.n, a.integers, n);
    case 6:
        return fmi3GetInt64(c, vr, a.n, a.longs, n);
    case 7:
        return fmi3GetBoolean(c, vr, a.n, a.flags, n);
    case 8:
        return fmi3GetFloat32(c, vr, a.n, NULL, n);
    case 9:
        return fmi3SetString(c, vr, a.n, NULL, n);
    case 10:
        return fmi3GetClock(c, vr, a.n, a.flags);
    default:
        return fmi3GetDirectionalDerivative(c, vr, a.n, a.references, n, a.reals, n, a.reals, a.n);
    }
}

static int step3(fmi3Instance c, double h) {
    static const unsigned time_reference = N_VARIABLES;
    double t = 0.0, last = 0.0;
    bool flags[3];
    fmi3GetFloat64(c, &time_reference, 1, &t, 1);
    return fmi3DoStep(c, draw(9) ? t : number(), h, true, &flags[0], &flags[1], draw(20) ? &flags[2] : NULL, &last);
}

static int other_call3(fmi3Instance c, fmi3FMUState *state) {
    switch (draw(8)) {
    case 0:
        return fmi3SetFMUState(c, *state);
    case 1:
        return fmi3FreeFMUState(c, draw(5) ? state : NULL);
    case 2:
        return fmi3EnterEventMode(c);
    case 3:
        return fmi3EnterStepMode(c);
    case 4:
        return fmi3SetTime(c, number());
    case 5:
        return draw(8) ? fmi3OK : fmi3Terminate(c);
    case 6:
        return draw(8) ? fmi3OK : fmi3Reset(c);
    default:
        return fmi3GetFMUState(c, draw(9) ? state : NULL);
    }
}

static void run3(void) {
    fmi3Instance c = fmi3InstantiateCoSimulation("fuzz", draw(20) ? MODEL_GUID : "x", NULL, false, false, draw(30) == 0,
                                                 false, NULL, 0, NULL, draw(9) ? logger3 : NULL, NULL);
    fmi3FMUState state = NULL;
    for (int k = 0; k < CALLS; k++) {
        switch (draw(7)) {
        case 0:
            check_status(fmi3EnterInitializationMode(c, false, 0.0, draw(9) ? 0.0 : number(), false, 0.0));
            break;
        case 1:
            check_status(fmi3ExitInitializationMode(c));
            break;
        case 2:
            check_status(step3(c, some_step()));
            break;
        case 3:
            n_steps += step3(c, good_step()) == fmi3OK;
            break;
        case 4:
            check_status(other_call3(c, &state));
            break;
        default:
            check_status(value_call3(c));
        }
    }
    fmi3FreeFMUState(c, &state);
    fmi3FreeInstance(c);
}

/* What one thread does: sequences from a first seed on, each with instances of its own. */
typedef struct {
    unsigned first_seed;
    int n_sequences, n_messages, n_steps;
} Work;

static void *run(void *given) {
    Work *work = given;
    for (int k = 0; k < work->n_sequences; k++) {
        seed = work->first_seed + (unsigned)k;
        run2();
        run3();
    }
    work->n_messages = n_messages;
    work->n_steps = n_steps;
    return NULL;
}

/* host [sequences a thread [first seed [threads]]] */
int main(int argc, char **argv) {
    enum { MOST_THREADS = 16 };
    const int n_sequences = argc > 1 ? atoi(argv[1]) : 200;
    const unsigned first_seed = argc > 2 ? (unsigned)atoi(argv[2]) : 1000u;
    const int n_threads = argc > 3 && atoi(argv[3]) < MOST_THREADS ? atoi(argv[3]) : 1;
    Work works[MOST_THREADS] = {{0}};
    pthread_t threads[MOST_THREADS];
    int all_messages = 0, all_steps = 0;
    for (int i = 0; i < n_threads; i++) {
        works[i] = (Work){.first_seed = first_seed + (unsigned)(i * n_sequences), .n_sequences = n_sequences};
        if (pthread_create(&threads[i], NULL, run, &works[i]) != 0) {
            return 4;
        }
    }
    for (int i = 0; i < n_threads; i++) {
        pthread_join(threads[i], NULL);
        all_messages += works[i].n_messages;
        all_steps += works[i].n_steps;
    }
    printf("%d sequences, %d calls, %d messages, %d good steps\n", n_threads * n_sequences,
           n_threads * n_sequences * 2 * CALLS, all_messages, all_steps);
    return all_messages > 0 && all_steps > 0 ? 0 : 3;
}

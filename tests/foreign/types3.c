/*
 * FMI 3.0: every type passes from its input to its output; arrays come out doubled. Written without the headers.
 * `answer` is a status from 0.2 s on, or one of the requests below. With the token "events" it works in event
 * mode only: events at 0.15 s and 0.35 s; ib counts entries of event mode and updates there; inputs are refused in
 * step mode.
 */
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

enum { END = 10, END_WITHIN, EARLY, NO_PROGRESS, EVENTS };
enum { FREE, EVENT_MODE, STEP_MODE };

typedef void Log(void *environment, int status, const char *category, const char *message);

typedef struct {
    double Float64[2], a[6], b[6];
    float Float32[2];
    int8_t Int8[2];
    uint8_t UInt8[2];
    int16_t Int16[2];
    uint16_t UInt16[2];
    int32_t Int32[2], ia[2], ib[2], answer;
    uint32_t UInt32[2];
    int64_t Int64[2];
    uint64_t UInt64[2];
    bool Boolean[2], ba[2], bb[2];
    char label[64];
    void *environment;
    Log *log;
    int mode, pending, calls;
} Fmu;

static void *place(Fmu *c, uint32_t r, void *scalars, size_t size, size_t *n) {
    *n = 1;
    switch (r) {
    case 100: *n = 6; return c->a;
    case 101: *n = 6; return c->b;
    case 110: *n = 2; return c->ia;
    case 111: *n = 2; return c->ib;
    case 112: *n = 2; return c->ba;
    case 113: *n = 2; return c->bb;
    case 120: return &c->answer;
    default: return (char *)scalars + (r % 2) * size;
    }
}

#define TYPE(name, type)                                                                               \
    int fmi3Set##name(Fmu *c, const uint32_t *r, size_t n, const type *v, size_t n_values) {           \
        size_t k = 0, m;                                                                               \
        if (c->mode == STEP_MODE) {                                                                    \
            return 3;                                                                                  \
        }                                                                                              \
        for (size_t i = 0; i < n; i++, k += m) {                                                       \
            void *to = place(c, r[i], c->name, sizeof(type), &m);                                      \
            memcpy(to, v + k, m * sizeof(type));                                                       \
        }                                                                                              \
        return k == n_values ? 0 : 3;                                                                  \
    }                                                                                                  \
    int fmi3Get##name(Fmu *c, const uint32_t *r, size_t n, type *v, size_t n_values) {                 \
        size_t k = 0, m;                                                                               \
        for (size_t i = 0; i < n; i++, k += m) {                                                       \
            const void *from = place(c, r[i], c->name, sizeof(type), &m);                              \
            memcpy(v + k, from, m * sizeof(type));                                                     \
        }                                                                                              \
        return k == n_values ? 0 : 3;                                                                  \
    }

TYPE(Float64, double)
TYPE(Float32, float)
TYPE(Int8, int8_t)
TYPE(UInt8, uint8_t)
TYPE(Int16, int16_t)
TYPE(UInt16, uint16_t)
TYPE(Int32, int32_t)
TYPE(UInt32, uint32_t)
TYPE(Int64, int64_t)
TYPE(UInt64, uint64_t)
TYPE(Boolean, bool)

#define PASS(name) c->name[1] = c->name[0];

static void outputs(Fmu *c) {
    PASS(Float64) PASS(Float32) PASS(Int8) PASS(UInt8) PASS(Int16) PASS(UInt16)
    PASS(Int32) PASS(UInt32) PASS(Int64) PASS(UInt64) PASS(Boolean)
    for (int i = 0; i < 6; i++) {
        c->b[i] = 2.0 * c->a[i];
    }
    for (int i = 0; i < 2; i++) {
        c->ib[i] = c->mode == FREE ? 2 * c->ia[i] : c->ib[i];
        c->bb[i] = !c->ba[i];
    }
}

int fmi3SetString(Fmu *c, const uint32_t *r, size_t n, const char *const *v, size_t n_values) {
    (void)r, (void)n, (void)n_values;
    strncpy(c->label, v[0], sizeof c->label - 1);
    return 0;
}

void *fmi3InstantiateCoSimulation(const char *name, const char *token, const char *resources, bool visible,
                                  bool logging, bool events, bool early, const uint32_t *required, size_t n,
                                  void *environment, Log *log, void *update) {
    (void)name, (void)resources, (void)visible, (void)logging, (void)required, (void)n, (void)update;
    if (!strcmp(token, "events") && !(events && early)) {
        log(environment, 3, "status", "works in event mode only");
        return NULL;
    }
    Fmu *c = calloc(1, sizeof *c);
    for (int i = 0; i < 6; i++) {
        c->a[i] = i + 1.0;
    }
    c->environment = environment;
    c->log = log;
    c->mode = events ? EVENT_MODE : FREE;
    return c;
}

void fmi3FreeInstance(Fmu *c) { free(c); }
int fmi3EnterInitializationMode(Fmu *c, bool a, double b, double t, bool d, double e) {
    (void)c, (void)a, (void)b, (void)t, (void)d, (void)e;
    return 0;
}
int fmi3ExitInitializationMode(Fmu *c) { outputs(c); c->pending = 2; return 0; }
int fmi3Terminate(Fmu *c) { (void)c; return 0; }

int fmi3DoStep(Fmu *c, double t, double h, bool no_set, bool *event, bool *end, bool *early, double *last) {
    (void)no_set;
    *event = *end = *early = false;
    *last = t + h;
    if (c->mode == EVENT_MODE) {
        return 3;
    }
    if (c->mode == STEP_MODE) {
        for (double at = 0.15; at < 0.4; at += 0.2) {
            if (t < at - 1e-9 && at + 1e-9 < t + h) {
                *last = at;
                *event = *early = true;
                break;
            }
        }
    }
    outputs(c);
    if (c->answer > 0 && t > 0.15) {
        c->log(c->environment, c->answer < END ? c->answer : 1, "status", c->label);
        *end = c->answer == END || c->answer == END_WITHIN;
        *early = c->answer == EARLY || c->answer == NO_PROGRESS || c->answer == END_WITHIN;
        *event = c->answer == EVENTS;
        *last = c->answer == NO_PROGRESS ? t : *early ? t + (h > 0.02 ? h / 2 : h) : *last;
        c->b[0] += ++c->calls;
        return c->answer < END ? c->answer : 0;
    }
    return 0;
}

int fmi3EnterEventMode(Fmu *c) {
    c->ib[0]++;
    c->pending = 2;
    return c->mode == STEP_MODE ? (c->mode = EVENT_MODE, 0) : 3;
}
int fmi3EnterStepMode(Fmu *c) { return c->mode == EVENT_MODE && !c->pending ? (c->mode = STEP_MODE, 0) : 3; }

int fmi3UpdateDiscreteStates(Fmu *c, bool *again, bool *end, bool *nominals, bool *values, bool *defined,
                             double *next) {
    (void)nominals, (void)values, (void)defined, (void)next;
    c->ib[1]++;
    c->pending -= c->pending > 0;
    *again = c->pending > 0;
    *end = false;
    outputs(c);
    return c->mode == EVENT_MODE ? 0 : 3;
}

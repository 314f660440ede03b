/* FMI 2.0: every type passes from its input to its output. Written without the headers. */
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

enum { END = 10 }; /* `answer`: discard a step and end the simulation */

typedef void Log(void *environment, const char *name, int status, const char *category, const char *text, ...);

typedef struct {
    Log *log;
    void *allocate, *free, *finished, *environment;
} Callbacks;

typedef struct {
    double Real[2];
    int Integer[4]; /* 0, 1: integer; 2, 3: enumeration */
    int Boolean[2], answer;
    char label[64];
    const Callbacks *callbacks;
} Fmu;

const char *fmi2GetVersion(void) { return "2.0"; }
const char *fmi2GetTypesPlatform(void) { return "default"; }

#define TYPE(name, type)                                                                \
    int fmi2Set##name(Fmu *c, const unsigned *r, size_t n, const type *v) {             \
        for (size_t i = 0; i < n; i++) {                                                \
            *(r[i] == 120 ? (type *)&c->answer : &c->name[r[i] % 10]) = v[i];           \
        }                                                                               \
        return 0;                                                                       \
    }                                                                                   \
    int fmi2Get##name(Fmu *c, const unsigned *r, size_t n, type *v) {                   \
        for (size_t i = 0; i < n; i++) {                                                \
            v[i] = c->name[r[i] % 10];                                                  \
        }                                                                               \
        return 0;                                                                       \
    }

TYPE(Real, double)
TYPE(Integer, int)
TYPE(Boolean, int)

static void outputs(Fmu *c) {
    c->Real[1] = c->Real[0];
    c->Integer[1] = c->Integer[0];
    c->Integer[3] = c->Integer[2];
    c->Boolean[1] = c->Boolean[0];
}

int fmi2SetString(Fmu *c, const unsigned *r, size_t n, const char *const *v) {
    (void)r, (void)n;
    strncpy(c->label, v[0], sizeof c->label - 1);
    return 0;
}

void *fmi2Instantiate(const char *name, int type, const char *guid, const char *resources,
                      const Callbacks *callbacks, int visible, int logging) {
    (void)name, (void)type, (void)guid, (void)resources, (void)visible, (void)logging;
    Fmu *c = calloc(1, sizeof *c);
    c->callbacks = callbacks;
    return c;
}

void fmi2FreeInstance(Fmu *c) { free(c); }
int fmi2SetupExperiment(Fmu *c, int a, double b, double t, int d, double e) {
    (void)c, (void)a, (void)b, (void)t, (void)d, (void)e;
    return 0;
}
int fmi2EnterInitializationMode(Fmu *c) { (void)c; return 0; }
int fmi2ExitInitializationMode(Fmu *c) { outputs(c); return 0; }
int fmi2Terminate(Fmu *c) { (void)c; return 0; }

int fmi2DoStep(Fmu *c, double t, double h, int no_set) {
    (void)h, (void)no_set;
    outputs(c);
    if (c->answer > 0 && t > 0.15) {
        int status = c->answer == END ? 2 : c->answer;
        c->callbacks->log(c->callbacks->environment, "fmu", status, "status", c->label);
        return status;
    }
    return 0;
}

int fmi2GetBooleanStatus(Fmu *c, int kind, int *value) {
    *value = kind == 3 && c->answer == END;
    return 0;
}

/* FMI 2.0: an integrator that does to its process, in a call, what its instance is named after, as exit_step. */
#include <pthread.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

typedef struct {
    char name[64];
    double values[2];
    int steps;
} Fmu;

enum { OUTPUT, INPUT };

static void *count(void *steps) {
    for (;;) {
        ++*(volatile int *)steps;
    }
    return NULL;
}

static void do_deed(const Fmu *c, const char *call) {
    const char *where = strchr(c->name, '_');
    if (where == NULL || strcmp(where + 1, call) != 0) {
        return;
    }
    if (strncmp(c->name, "exit", 4) == 0) {
        exit(0);
    } else if (strncmp(c->name, "crash", 5) == 0) {
        *(volatile int *)8 = 1;
    } else if (strncmp(c->name, "chdir", 5) == 0) {
        (void)!chdir("/");
    } else if (strncmp(c->name, "thread", 6) == 0) {
        static int n;
        pthread_t thread;
        pthread_create(&thread, NULL, count, &n);
    }
}

void *fmi2Instantiate(const char *name, int type, const char *guid, const char *resources, const void *callbacks,
                      int visible, int logging) {
    (void)type, (void)guid, (void)resources, (void)callbacks, (void)visible, (void)logging;
    Fmu *c = calloc(1, sizeof *c);
    strncpy(c->name, name, sizeof c->name - 1);
    do_deed(c, "instantiate");
    return c;
}
void fmi2FreeInstance(Fmu *c) { do_deed(c, "free"); free(c); }
int fmi2SetupExperiment(Fmu *c, int a, double b, double t, int d, double e) {
    (void)c, (void)a, (void)b, (void)t, (void)d, (void)e;
    return 0;
}
int fmi2EnterInitializationMode(Fmu *c) { do_deed(c, "init"); return 0; }
int fmi2ExitInitializationMode(Fmu *c) { (void)c; return 0; }
int fmi2Terminate(Fmu *c) { return strcmp(c->name, "discard_terminate") == 0 ? 2 : 0; }
int fmi2Reset(Fmu *c) { c->values[OUTPUT] = 0.0; c->steps = 0; return 0; }

int fmi2DoStep(Fmu *c, double t, double h, int no_set) {
    (void)t, (void)no_set;
    c->values[OUTPUT] += h * c->values[INPUT];
    if (++c->steps == 10) {
        do_deed(c, "step");
    }
    return 0;
}
int fmi2SetReal(Fmu *c, const unsigned *r, size_t n, const double *v) {
    for (size_t i = 0; i < n; i++) {
        c->values[r[i]] = v[i];
    }
    return 0;
}
int fmi2GetReal(Fmu *c, const unsigned *r, size_t n, double *v) {
    for (size_t i = 0; i < n; i++) {
        v[i] = c->values[r[i]];
    }
    return 0;
}
int fmi2GetFMUstate(Fmu *c, void **state) {
    do_deed(c, "state");
    if (*state == NULL) {
        *state = malloc(sizeof *c);
    }
    memcpy(*state, c, sizeof *c);
    return 0;
}
int fmi2SetFMUstate(Fmu *c, void *state) { do_deed(c, "restore"); memcpy(c, state, sizeof *c); return 0; }
int fmi2FreeFMUstate(Fmu *c, void **state) { (void)c; free(*state); *state = NULL; return 0; }

/* FMI 2.0: each output is half its input and one more; references 0 to PORTS - 1 are inputs, then outputs. */
#include <stddef.h>
#include <stdlib.h>

#ifndef PORTS
#define PORTS 25
#endif

typedef struct {
    double value[2 * PORTS];
} Fmu;

const char *fmi2GetVersion(void) { return "2.0"; }
const char *fmi2GetTypesPlatform(void) { return "default"; }

void *fmi2Instantiate(const char *name, int kind, const char *guid, const char *place, const void *callbacks,
                      int visible, int logging) {
    return calloc(1, sizeof(Fmu));
}
void fmi2FreeInstance(Fmu *c) { free(c); }
int fmi2SetDebugLogging(Fmu *c, int on, size_t n, const char *const *categories) { return 0; }
int fmi2SetupExperiment(Fmu *c, int d, double t, double start, int s, double stop) { return 0; }
int fmi2EnterInitializationMode(Fmu *c) { return 0; }
int fmi2ExitInitializationMode(Fmu *c) { return 0; }
int fmi2Terminate(Fmu *c) { return 0; }
int fmi2Reset(Fmu *c) { return 0; }

int fmi2SetReal(Fmu *c, const unsigned *r, size_t n, const double *v) {
    for (size_t i = 0; i < n; i++) {
        if (r[i] < 2 * PORTS) {
            c->value[r[i]] = v[i];
        }
    }
    return 0;
}
int fmi2GetReal(Fmu *c, const unsigned *r, size_t n, double *v) {
    for (size_t i = 0; i < n; i++) {
        v[i] = r[i] < 2 * PORTS ? c->value[r[i]] : 0.0;
    }
    return 0;
}
int fmi2DoStep(Fmu *c, double t, double h, int noSetFMUStatePriorToCurrentPoint) {
    for (int i = 0; i < PORTS; i++) {
        c->value[PORTS + i] = 1.0 + 0.5 * c->value[i];
    }
    return 0;
}

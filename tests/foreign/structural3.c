/* FMI 3.0: y[i] = (i + 1) u[i] for i < n; n is a structural parameter, set in configuration mode alone. */
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>

enum { N = 1, U = 2, Y = 3, MOST = 100 };

typedef struct {
    uint64_t n;
    double u[MOST], y[MOST];
    int configures;
} Fmu;

static void compute(Fmu *c) {
    for (size_t i = 0; i < c->n; i++) {
        c->y[i] = (double)(i + 1) * c->u[i];
    }
}

void *fmi3InstantiateCoSimulation(const char *name, const char *token, const char *resources, bool visible,
                                  bool logging, bool events, bool early, const unsigned *required, size_t n_required,
                                  void *environment, void *log, void *update) {
    (void)name, (void)token, (void)resources, (void)visible, (void)logging, (void)events, (void)early;
    (void)required, (void)n_required, (void)environment, (void)log, (void)update;
    Fmu *c = calloc(1, sizeof *c);
    c->n = 2;
    for (size_t i = 0; i < MOST; i++) {
        c->u[i] = 0.5;
    }
    return c;
}
void fmi3FreeInstance(Fmu *c) { free(c); }
int fmi3EnterConfigurationMode(Fmu *c) { c->configures = 1; return 0; }
int fmi3ExitConfigurationMode(Fmu *c) { c->configures = 0; return 0; }
int fmi3EnterInitializationMode(Fmu *c, bool a, double b, double t, bool d, double e) {
    (void)a, (void)b, (void)t, (void)d, (void)e;
    return c->configures ? 3 : 0;
}
int fmi3ExitInitializationMode(Fmu *c) { compute(c); return 0; }
int fmi3Terminate(Fmu *c) { (void)c; return 0; }
int fmi3DoStep(Fmu *c, double t, double h, bool no_set, bool *events, bool *end, bool *early, double *last) {
    (void)no_set;
    compute(c);
    *events = *end = *early = false;
    *last = t + h;
    return 0;
}
int fmi3SetUInt64(Fmu *c, const unsigned *r, size_t n, const uint64_t v[], size_t n_values) {
    if (!c->configures || n != 1 || n_values != 1 || r[0] != N || v[0] > MOST) {
        return 3;
    }
    c->n = v[0];
    return 0;
}
int fmi3GetUInt64(Fmu *c, const unsigned *r, size_t n, uint64_t v[], size_t n_values) {
    (void)n, (void)n_values;
    v[0] = c->n;
    return r[0] == N ? 0 : 3;
}
int fmi3SetFloat64(Fmu *c, const unsigned *r, size_t n, const double v[], size_t n_values) {
    if (c->configures || n != 1 || r[0] != U || n_values != c->n) {
        return 3;
    }
    for (size_t i = 0; i < c->n; i++) {
        c->u[i] = v[i];
    }
    return 0;
}
int fmi3GetFloat64(Fmu *c, const unsigned *r, size_t n, double v[], size_t n_values) {
    if (n != 1 || n_values != c->n) {
        return 3;
    }
    for (size_t i = 0; i < c->n; i++) {
        v[i] = r[0] == U ? c->u[i] : c->y[i];
    }
    return 0;
}

/* FMI 2.0: y = p t; from p = 2 on it ends its process, from 3 it never returns, from 4 it answers with an error.
   Below p = 0 a step takes 2 ms at least, on any machine. */
#include <stddef.h>
#include <stdlib.h>
#include <unistd.h>

typedef struct { double p, y, t; } Fmu;

void *fmi2Instantiate(const char *name, int type, const char *guid, const char *resources, const void *callbacks,
                      int visible, int logging) {
    (void)name, (void)type, (void)guid, (void)resources, (void)callbacks, (void)visible, (void)logging;
    return calloc(1, sizeof(Fmu));
}
void fmi2FreeInstance(Fmu *c) { free(c); }
int fmi2SetupExperiment(Fmu *c, int a, double b, double t, int d, double e) {
    (void)c, (void)a, (void)b, (void)t, (void)d, (void)e;
    return 0;
}
int fmi2EnterInitializationMode(Fmu *c) { (void)c; return 0; }
int fmi2ExitInitializationMode(Fmu *c) { (void)c; return 0; }
int fmi2Terminate(Fmu *c) { (void)c; return 0; }
int fmi2Reset(Fmu *c) { c->p = c->y = c->t = 0.0; return 0; }

int fmi2DoStep(Fmu *c, double t, double h, int no_set) {
    (void)no_set;
    c->t = t + h;
    c->y += h * c->p;
    if (c->p < 0.0) {
        usleep(2000);
    }
    if (c->t < 0.45) {
        return 0;
    }
    if (c->p >= 4.0) {
        return 3;
    }
    if (c->p >= 3.0) {
        for (;;) {
            sleep(1);
        }
    }
    if (c->p >= 2.0) {
        *(volatile int *)8 = 1;
    }
    return 0;
}
int fmi2SetReal(Fmu *c, const unsigned *r, size_t n, const double *v) {
    for (size_t i = 0; i < n; i++) {
        if (r[i] == 0) {
            c->p = v[i];
        }
    }
    return 0;
}
int fmi2GetReal(Fmu *c, const unsigned *r, size_t n, double *v) {
    for (size_t i = 0; i < n; i++) {
        v[i] = r[i] == 0 ? c->p : c->y;
    }
    return 0;
}

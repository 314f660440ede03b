/* FMI 2.0: sums whose bits depend on the floating-point mode, which `deed` says to change. No headers of FMI. */
#define _GNU_SOURCE
#include <fenv.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>

enum { NOTHING, FLUSH_TO_ZERO, ROUND_UP, TRAP, LOG };
enum { CHAOS, SMALL, QUOTIENT, MEMORY, INPUT };

typedef void Log(void *environment, const char *name, int status, const char *category, const char *text, ...);

typedef struct {
    Log *log;
    void *allocate, *free, *finished, *environment;
} Callbacks;

typedef struct {
    double values[5];
    int deed, steps;
    const Callbacks *callbacks;
} Fmu;

static volatile double zero = 0.0;

/* Memory of this process that no other one shares [kB]. */
static double own_memory(void) {
    FILE *file = fopen("/proc/self/status", "r");
    char line[256];
    double kilobytes = -1.0;
    while (file && fgets(line, sizeof line, file)) {
        sscanf(line, "RssAnon: %lf", &kilobytes);
    }
    if (file) {
        fclose(file);
    }
    return kilobytes;
}

static void do_deed(Fmu *c) {
    if (c->deed == FLUSH_TO_ZERO) {
#if defined __x86_64__
        __builtin_ia32_ldmxcsr(__builtin_ia32_stmxcsr() | 0x8040);
#elif defined __aarch64__
        unsigned long mode;
        __asm__ volatile("mrs %0, fpcr" : "=r"(mode));
        __asm__ volatile("msr fpcr, %0" : : "r"(mode | 1UL << 24));
#endif
    }
    if (c->deed == ROUND_UP) {
        fesetround(FE_UPWARD);
    }
    if (c->deed == TRAP) {
        feenableexcept(FE_DIVBYZERO | FE_INVALID | FE_UNDERFLOW);
    }
    if (c->deed == LOG) {
        c->callbacks->log(c->callbacks->environment, "fmu", 1, "each", "step %d is one of many", c->steps);
    }
}

void *fmi2Instantiate(const char *name, int type, const char *guid, const char *resources,
                      const Callbacks *callbacks, int visible, int logging) {
    (void)name, (void)type, (void)guid, (void)resources, (void)visible, (void)logging;
    Fmu *c = calloc(1, sizeof *c);
    c->callbacks = callbacks;
    c->values[CHAOS] = 0.3;
    c->values[SMALL] = 1e-300;
    return c;
}

void fmi2FreeInstance(Fmu *c) { free(c); }
int fmi2SetupExperiment(Fmu *c, int a, double b, double t, int d, double e) {
    (void)c, (void)a, (void)b, (void)t, (void)d, (void)e;
    return 0;
}
int fmi2EnterInitializationMode(Fmu *c) { (void)c; return 0; }
int fmi2ExitInitializationMode(Fmu *c) { (void)c; return 0; }
int fmi2Terminate(Fmu *c) { (void)c; return 0; }

int fmi2DoStep(Fmu *c, double t, double h, int no_set) {
    (void)t, (void)h, (void)no_set;
    double *v = c->values;
    v[CHAOS] = 3.9 * v[CHAOS] * (1.0 - v[CHAOS]);
    v[SMALL] *= 0.7;
    if (c->deed == NOTHING) { /* what divides by zero in a mode with traps ends its process */
        v[QUOTIENT] = 1.0 / zero;
    }
    if (c->steps % 1000 == 0) {
        v[MEMORY] = own_memory();
    }
    c->steps++;
    do_deed(c);
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
        v[i] = c->values[r[i] > INPUT ? INPUT : r[i]];
    }
    return 0;
}
int fmi2SetInteger(Fmu *c, const unsigned *r, size_t n, const int *v) {
    (void)r, (void)n;
    c->deed = v[0];
    return 0;
}
int fmi2GetInteger(Fmu *c, const unsigned *r, size_t n, int *v) {
    (void)r, (void)n;
    v[0] = c->deed;
    return 0;
}

/*
 * A slave with any number of variables, for random systems; FMI is 2 or 3. Written without the headers.
 *
 * resources/layout.txt has a line "kind reference n role weight" and n start values for each value reference; role
 * is i (input), o (output) or p (parameter). With S = sum of weight (e + 1) value over the elements e of inputs and parameters,
 * a step from t sets every element of an output to
 *
 *     w = sin(weight S + reference + e + t)
 *     floats 0.25 y + w, integers floor(50 w), unsigned ones and enumerations floor(1.999 (1 + w)) + 1, Booleans w > 0
 */
#include <math.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { MOST = 64, ELEMENTS = 8 };

typedef struct {
    char kind[16], role;
    unsigned reference;
    size_t n;
    double weight, value[ELEMENTS];
} Variable;

typedef struct {
    Variable variables[MOST];
    size_t n;
} Mixer;

static Variable *find(Mixer *m, unsigned reference, const char *kind) {
    for (size_t i = 0; i < m->n; i++) {
        if (m->variables[i].reference == reference && !strcmp(m->variables[i].kind, kind)) {
            return &m->variables[i];
        }
    }
    return NULL;
}

static Mixer *make(const char *resources, const char *separator) {
    char path[4096];
    const char *folder = strncmp(resources, "file://", 7) ? resources : resources + 7;
    snprintf(path, sizeof path, "%s%slayout.txt", folder, separator);
    FILE *file = fopen(path, "r");
    if (!file) {
        return NULL;
    }
    Mixer *m = calloc(1, sizeof *m);
    Variable *v = m->variables;
    while (m->n < MOST && fscanf(file, "%15s %u %zu %c %lf", v->kind, &v->reference, &v->n, &v->role, &v->weight) == 5) {
        for (size_t e = 0; e < v->n; e++) {
            if (fscanf(file, "%lf", &v->value[e]) != 1) {
                fclose(file);
                free(m);
                return NULL;
            }
        }
        v++, m->n++;
    }
    fclose(file);
    return m;
}

static double element(const Variable *v, size_t e, double w) {
    if (!strncmp(v->kind, "Float", 5) || !strcmp(v->kind, "Real")) {
        return 0.25 * v->value[e] + w;
    }
    if (!strcmp(v->kind, "Boolean")) {
        return w > 0.0;
    }
    if (v->kind[0] == 'U' || !strcmp(v->kind, "Enumeration")) {
        return floor(1.999 * (1.0 + w)) + 1.0;
    }
    return floor(50.0 * w);
}

static int step(Mixer *m, double t) {
    double sum = 0.0;
    for (size_t i = 0; i < m->n; i++) {
        const Variable *v = &m->variables[i];
        for (size_t e = 0; v->role != 'o' && e < v->n; e++) {
            sum += v->weight * (double)(e + 1) * v->value[e];
        }
    }
    for (size_t i = 0; i < m->n; i++) {
        Variable *v = &m->variables[i];
        for (size_t e = 0; v->role == 'o' && e < v->n; e++) {
            v->value[e] = element(v, e, sin(v->weight * sum + v->reference + (double)e + t));
        }
    }
    return 0;
}

#if FMI == 2

#define TYPE(name, type, kind)                                                  \
    int fmi2Set##name(Mixer *m, const unsigned *r, size_t n, const type *x) {   \
        for (size_t i = 0; i < n; i++) {                                        \
            Variable *v = find(m, r[i], #name);                                 \
            v = v ? v : find(m, r[i], kind);                                    \
            if (!v) {                                                           \
                return 3;                                                       \
            }                                                                   \
            v->value[0] = x[i];                                                 \
        }                                                                       \
        return 0;                                                               \
    }                                                                           \
    int fmi2Get##name(Mixer *m, const unsigned *r, size_t n, type *x) {         \
        for (size_t i = 0; i < n; i++) {                                        \
            Variable *v = find(m, r[i], #name);                                 \
            v = v ? v : find(m, r[i], kind);                                    \
            if (!v) {                                                           \
                return 3;                                                       \
            }                                                                   \
            x[i] = (type)v->value[0];                                           \
        }                                                                       \
        return 0;                                                               \
    }

TYPE(Real, double, "Real")
TYPE(Integer, int, "Enumeration")
TYPE(Boolean, int, "Boolean")

void *fmi2Instantiate(const char *name, int type, const char *guid, const char *resources, const void *callbacks,
                      int visible, int logging) {
    (void)name, (void)type, (void)guid, (void)callbacks, (void)visible, (void)logging;
    return make(resources, "/");
}
void fmi2FreeInstance(Mixer *m) { free(m); }
int fmi2SetupExperiment(Mixer *m, int a, double b, double c, int d, double e) {
    (void)m, (void)a, (void)b, (void)c, (void)d, (void)e;
    return 0;
}
int fmi2EnterInitializationMode(Mixer *m) { (void)m; return 0; }
int fmi2ExitInitializationMode(Mixer *m) { (void)m; return 0; }
int fmi2Terminate(Mixer *m) { (void)m; return 0; }
int fmi2DoStep(Mixer *m, double t, double h, int no_set) { (void)h, (void)no_set; return step(m, t); }

#else

#define TYPE(name, type)                                                                              \
    int fmi3Set##name(Mixer *m, const uint32_t *r, size_t n, const type *x, size_t n_values) {        \
        size_t k = 0;                                                                                 \
        for (size_t i = 0; i < n; i++) {                                                              \
            Variable *v = find(m, r[i], #name);                                                       \
            for (size_t e = 0; v && k < n_values && e < v->n; e++) {                                  \
                v->value[e] = (double)x[k++];                                                         \
            }                                                                                         \
            if (!v) {                                                                                 \
                return 3;                                                                             \
            }                                                                                         \
        }                                                                                             \
        return k == n_values ? 0 : 3;                                                                 \
    }                                                                                                 \
    int fmi3Get##name(Mixer *m, const uint32_t *r, size_t n, type *x, size_t n_values) {              \
        size_t k = 0;                                                                                 \
        for (size_t i = 0; i < n; i++) {                                                              \
            Variable *v = find(m, r[i], #name);                                                       \
            for (size_t e = 0; v && k < n_values && e < v->n; e++) {                                  \
                x[k++] = (type)v->value[e];                                                           \
            }                                                                                         \
            if (!v) {                                                                                 \
                return 3;                                                                             \
            }                                                                                         \
        }                                                                                             \
        return k == n_values ? 0 : 3;                                                                 \
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

void *fmi3InstantiateCoSimulation(const char *name, const char *token, const char *resources, bool visible,
                                  bool logging, bool events, bool early, const uint32_t *required, size_t n,
                                  void *environment, void *log, void *update) {
    (void)name, (void)token, (void)visible, (void)logging, (void)events, (void)early, (void)required, (void)n;
    (void)environment, (void)log, (void)update;
    return make(resources, "/");
}
void fmi3FreeInstance(Mixer *m) { free(m); }
int fmi3EnterInitializationMode(Mixer *m, bool a, double b, double t, bool d, double e) {
    (void)m, (void)a, (void)b, (void)t, (void)d, (void)e;
    return 0;
}
int fmi3ExitInitializationMode(Mixer *m) { (void)m; return 0; }
int fmi3Terminate(Mixer *m) { (void)m; return 0; }
int fmi3DoStep(Mixer *m, double t, double h, bool no_set, bool *event, bool *end, bool *early, double *last) {
    (void)no_set;
    *event = *end = *early = false;
    *last = t + h;
    return step(m, t);
}

#endif

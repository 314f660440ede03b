/* Whole runs of a system without a call of FMI between two ticks, for a master that makes many. */

#include "runs.h"

#include <math.h>
#include <stdint.h>
#include <string.h>

#include "lifecycle.h"
#include "recorded.h"

#if defined(__GNUC__)
#define VISIBLE __attribute__((visibility("default")))
#else
#define VISIBLE
#endif

/* Signals by their places in a row. */
typedef struct {
    const int64_t *places;
    int64_t n;
} Chosen;

/* How a run ended: after how many ticks, the watched signal that was beyond its limit, or -1, and its value. */
typedef struct {
    int64_t ticks;
    int64_t beyond;
    double value;
} Ended;

static void keep_quiet(const Instance *instance, const char *message) {
    (void)instance, (void)message; /* the master repeats the run with the FMUs, which report the fault */
}

static void keep(const double *row, const Chosen *kept, double *chosen) {
    for (int64_t i = 0; i < kept->n; i++) {
        chosen[i] = row[kept->places[i]];
    }
}

static int64_t first_beyond(const double *row, const Chosen *watched, const double *limits) {
    for (int64_t i = 0; i < watched->n; i++) {
        if (!(fabs(row[watched->places[i]]) <= limits[i])) {
            return i;
        }
    }
    return -1;
}

VISIBLE Instance *runs_open(void) {
    Instance *instance = instance_create("system");
    if (instance != NULL) {
        instance->log = keep_quiet;
    }
    return instance;
}

VISIBLE void runs_close(Instance *instance) {
    instance_free(instance);
}

/* From start values of parameters, inputs and states to at most n ticks and n + 1 rows; false if an FMU
   refuses anything. */
VISIBLE bool runs_make(Instance *instance, const double *start, double t0, int64_t n, const Chosen *kept,
                       const Chosen *watched, const double *limits, double *rows, Ended *ended) {
    double row[ROOM(N_RECORDED)];
    Memory *const memory = &instance->now.memory;
    instance_reset(instance);
    memcpy(instance->now.values, start, FIRST_OUTPUT * sizeof *start);
    instance->now.is_unchecked = 1;
    *ended = (Ended){.beyond = -1};
    if (!enter_initialisation(instance, "run", t0) || !exit_initialisation(instance, "run")) {
        return false;
    }
    system_attach(memory);
    system_record(memory, row);
    keep(row, kept, rows);
    while (ended->ticks < n && ended->beyond < 0) {
#ifdef N_EVENTS
        system_play(memory, instance->now.values);
#endif
        if (!system_tick(memory)) {
            return false;
        }
        ended->ticks++;
        system_record(memory, row);
        keep(row, kept, rows + ended->ticks * kept->n);
        ended->beyond = first_beyond(row, watched, limits);
    }
    if (ended->beyond >= 0) {
        ended->value = row[watched->places[ended->beyond]];
    }
    return true;
}

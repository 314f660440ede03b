/* One run of the model: its numbers, its phase, and whom it tells what is wrong. */

#ifndef INSTANCE_H
#define INSTANCE_H

#include <stdbool.h>

#include "model.h"
#include "text.h"

/* A function for what is not usual: it stays out of the code that runs in every step. */
#if defined(__GNUC__)
#define RARE __attribute__((cold, noinline))
#else
#define RARE
#endif

/* Bits, so that a call can name all phases in which it is allowed. */
typedef enum {
    INSTANTIATED = 1,
    INITIALISING = 2,
    STEPPING = 4,
    TERMINATED = 8,
    FAILED = 16
} Phase;

enum {
    BEFORE_RUN = INSTANTIATED | INITIALISING,
    AFTER_START = STEPPING | TERMINATED | FAILED,
    READABLE = INITIALISING | AFTER_START,
    WRITABLE = BEFORE_RUN | STEPPING,
    ANY_PHASE = INSTANTIATED | READABLE
};

/* All that a saved state must hold; copied as bytes. */
typedef struct {
    double values[N_VARIABLES];
    double previous_inputs[ROOM(N_INPUTS)];
    double time;
    int phase;
    int is_unchecked; /* a parameter was set since the last check */
} Data;

/* How a communication step of h [s] is cut: n sampling periods [s], each in equal substeps. */
typedef struct {
    double h;
    double period;
    int n;
    int n_substeps;
    double substep; /* s */
} Cut;

typedef struct Instance {
    Data now;
    Cut cut; /* of the last step: as a rule, all are cut alike */
    Data preview; /* what initialisation would give; states and outputs are read from it meanwhile */
    bool is_preview_valid;
    char *name;
    void *environment;
    void (*callback)(void); /* the importer's logger, cast back by `log` */
    void (*log)(const struct Instance *instance, const char *message);
} Instance;

/* A new instance with start values, or NULL without memory. */
Instance *instance_create(const char *name);
void instance_free(Instance *instance);

/* Return to the start values. */
void instance_reset(Instance *instance);

/* Write to the importer's logger; always returns false. */
RARE bool refuse(const Instance *instance, const char *format, ...);
RARE bool refuse_text(const Instance *instance, const Text *text);

/* Say that the present phase does not allow a call; always returns false. */
RARE bool refuse_phase(const Instance *instance, const char *function, int phases);

/* Refuse a call that the present phase does not allow. */
static inline bool allow(const Instance *instance, const char *function, int phases) {
    if (instance->now.phase & phases) {
        return true;
    }
    refuse_phase(instance, function, phases);
    return false;
}

/* Compute the states that follow from inputs and parameters, and the outputs. */
bool instance_initialise(const Instance *instance, Data *data);

/* What a reader sees: the preview while initialising; NULL if initialisation would fail. */
const Data *instance_readable(Instance *instance);

#endif

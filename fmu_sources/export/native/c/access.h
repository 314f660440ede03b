/* Reading and writing variables by value reference. */

#ifndef ACCESS_H
#define ACCESS_H

#include <stddef.h>

#include "instance.h"

/* A call that touches variables: its name for messages, and the type that it is for. */
typedef struct {
    const char *function;
    Type type;
} Access;

/* Any variable at any time, and what is wrong with the call. */
RARE bool read_any_value(Instance *instance, Access access, unsigned reference, double *value);
RARE bool write_any_value(Instance *instance, Access access, unsigned reference, double value);

/* Inline, as are the next ones, since a step reads and writes each connected variable: what is usual then is
   looked up at once. */
static inline bool read_value(Instance *instance, Access access, unsigned reference, double *value) {
    const bool is_usual = reference < N_VARIABLES && model_readable[reference] == access.type;
    if (is_usual && instance->now.phase != INITIALISING) {
        *value = instance->now.values[reference];
        return true;
    }
    return read_any_value(instance, access, reference, value);
}

static inline bool write_value(Instance *instance, Access access, unsigned reference, double value) {
    if (reference < N_VARIABLES && model_inputs[reference] == access.type) {
        instance->now.values[reference] = value;
        instance->is_preview_valid = false;
        return true;
    }
    return write_any_value(instance, access, reference, value);
}

/* Values of one type after the start; false, perhaps half-way, where anything else is wanted. */
static inline bool read_usual(const Instance *instance, Type type, const unsigned *references, size_t n,
                              double *values) {
    if (instance == NULL || !(instance->now.phase & AFTER_START) || references == NULL || values == NULL) {
        return false;
    }
    for (size_t i = 0; i < n; i++) {
        if (references[i] >= N_VARIABLES || model_readable[references[i]] != type) {
            return false;
        }
        values[i] = instance->now.values[references[i]];
    }
    return true;
}

/* Inputs of one type before and during the run; false, perhaps half-way, where anything else is wanted. */
static inline bool write_usual(Instance *instance, Type type, const unsigned *references, size_t n,
                               const double *values) {
    if (instance == NULL || !(instance->now.phase & WRITABLE) || references == NULL || values == NULL) {
        return false;
    }
    instance->is_preview_valid = false;
    for (size_t i = 0; i < n; i++) {
        if (references[i] >= N_VARIABLES || model_inputs[references[i]] != type) {
            return false;
        }
        instance->now.values[references[i]] = values[i];
    }
    return true;
}

/* The variable behind a reference, NULL (with a message) if there is none that the importer knows. */
const Variable *variable_at(const Instance *instance, const char *function, unsigned reference);

#endif

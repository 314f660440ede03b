/* Reading and writing variables by value reference. */

#ifndef ACCESS_H
#define ACCESS_H

#include "instance.h"

/* A call that touches variables: its name for messages, and the type that it is for. */
typedef struct {
    const char *function;
    Type type;
} Access;

/* Any variable at any time, and what is wrong with the call. */
bool read_any_value(Instance *instance, Access access, unsigned reference, double *value);
bool write_any_value(Instance *instance, Access access, unsigned reference, double value);

/* Inline, since a step reads and writes each connected variable: what is usual then is looked up at once. */
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

/* The variable behind a reference, NULL (with a message) if there is none that the importer knows. */
const Variable *variable_at(const Instance *instance, const char *function, unsigned reference);

#endif

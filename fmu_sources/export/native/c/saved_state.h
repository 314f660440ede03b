/* The whole state of an instance, saved, restored and as bytes. */

#ifndef SAVED_STATE_H
#define SAVED_STATE_H

#include <stddef.h>

#include "instance.h"

/* Save into *state, which is NULL or an earlier saved state. */
bool save_state(const Instance *instance, void **state);
bool restore_state(Instance *instance, const void *state);
void free_state(void **state);

size_t serialised_size(void);
bool serialise_state(const Instance *instance, const void *state, void *bytes, size_t size);
bool deserialise_state(const Instance *instance, const void *bytes, size_t size, void **state);

#endif

/* In the place of saved states: those of FMUs of other tools are not within the memory that is copied. */

#include "saved_state.h"

#include <stdlib.h>

#include "opened.h"

typedef struct {
    const Instance *owner;
    Data data;
    ForeignState *foreign[N_FOREIGN];
} Saved;

static bool refuse_state(const Instance *instance) {
    return refuse(instance, "FMU state: not supported, as an FMU of another tool in the system saves none");
}

static bool refuse_bytes(const Instance *instance) {
    return refuse(instance, "FMU state as bytes: not supported by a system with FMUs of other tools");
}

static bool refuse_of_foreign(const Instance *instance, int number) {
    const Foreign *const foreign = system_foreign(&instance->now.memory, number);
    return refuse(instance, "FMU state: %s: %s", foreign_name(foreign), foreign_said(foreign));
}

bool save_state(const Instance *instance, void **state) {
    if (!DO_FOREIGN_SAVE_STATE) {
        return refuse_state(instance);
    }
    if (state == NULL) {
        return refuse(instance, "FMU state: got no place to put it, expected a pointer");
    }
    if (*state == NULL) {
        *state = calloc(1, sizeof(Saved));
    }
    Saved *const saved = *state;
    if (saved == NULL) {
        return refuse(instance, "FMU state: out of memory");
    }
    saved->owner = instance;
    saved->data = instance->now;
    for (int i = 0; i < N_FOREIGN; i++) {
        if (!foreign_keep(system_foreign(&instance->now.memory, i), &saved->foreign[i])) {
            refuse_of_foreign(instance, i);
            free_state(state); /* half a state is none */
            return false;
        }
    }
    return true;
}

bool restore_state(Instance *instance, const void *state) {
    const Saved *const saved = state;
    if (saved == NULL || saved->owner != instance) {
        return refuse(instance, "FMU state: got none of this instance, expected one that it saved before");
    }
    for (int i = 0; i < N_FOREIGN; i++) {
        if (!foreign_bring_back(system_foreign(&instance->now.memory, i), saved->foreign[i])) {
            instance->now.phase = FAILED;
            return refuse_of_foreign(instance, i);
        }
    }
    instance->now = saved->data;
    instance->is_preview_valid = false;
    return true;
}

void free_state(void **state) {
    if (state == NULL || *state == NULL) {
        return;
    }
    Saved *const saved = *state;
    for (int i = 0; i < N_FOREIGN; i++) {
        foreign_forget(&saved->foreign[i]);
    }
    free(saved);
    *state = NULL;
}

size_t serialised_size(void) {
    return 0;
}

bool serialise_state(const Instance *instance, const void *state, void *bytes, size_t size) {
    (void)state, (void)bytes, (void)size;
    return refuse_bytes(instance);
}

bool deserialise_state(const Instance *instance, const void *bytes, size_t size, void **state) {
    (void)bytes, (void)size, (void)state;
    return refuse_bytes(instance);
}

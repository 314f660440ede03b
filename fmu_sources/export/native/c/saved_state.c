#include "saved_state.h"

#include <stdlib.h>
#include <string.h>

typedef struct {
    char guid[sizeof MODEL_GUID];
    Data data;
} Saved;

static const char NO_STATE[] = "FMU state: got none, expected one that was saved before";

static Saved *room_for(const Instance *instance, void **state) {
    if (state == NULL) {
        refuse(instance, "FMU state: got no place to put it, expected a pointer");
        return NULL;
    }
    if (*state == NULL) {
        *state = calloc(1, sizeof(Saved));
    }
    if (*state == NULL) {
        refuse(instance, "FMU state: out of memory");
    }
    return *state;
}

bool save_state(const Instance *instance, void **state) {
    Saved *saved = room_for(instance, state);
    if (saved == NULL) {
        return false;
    }
    memcpy(saved->guid, MODEL_GUID, sizeof MODEL_GUID);
    saved->data = instance->now;
    return true;
}

bool restore_state(Instance *instance, const void *state) {
    if (state == NULL) {
        return refuse(instance, NO_STATE);
    }
    instance->now = ((const Saved *)state)->data;
    instance->is_preview_valid = false;
    return true;
}

void free_state(void **state) {
    if (state != NULL) {
        free(*state);
        *state = NULL;
    }
}

size_t serialised_size(void) {
    return sizeof(Saved);
}

bool serialise_state(const Instance *instance, const void *state, void *bytes, size_t size) {
    if (state == NULL || bytes == NULL) {
        return refuse(instance, NO_STATE);
    }
    if (size < sizeof(Saved)) {
        return refuse(instance, "FMU state: place too small, got %lu bytes, expected %lu",
                      (unsigned long)size, (unsigned long)sizeof(Saved));
    }
    memcpy(bytes, state, sizeof(Saved));
    return true;
}

static bool is_phase(int phase) {
    return phase == INSTANTIATED || phase == INITIALISING || phase == STEPPING || phase == TERMINATED ||
           phase == FAILED;
}

bool deserialise_state(const Instance *instance, const void *bytes, size_t size, void **state) {
    Saved read;
    if (bytes == NULL || size != sizeof read) {
        return refuse(instance, "FMU state: wrong size, got %lu bytes, expected %lu", (unsigned long)size,
                      (unsigned long)sizeof read);
    }
    memcpy(&read, bytes, sizeof read);
    if (memcmp(read.guid, MODEL_GUID, sizeof MODEL_GUID) != 0 || !is_phase(read.data.phase)) {
        return refuse(instance, "FMU state: bytes of another model, expected those of " MODEL_GUID);
    }
    read.data.is_unchecked = 1; /* bytes may come from anywhere */
    Saved *saved = room_for(instance, state);
    if (saved == NULL) {
        return false;
    }
    *saved = read;
    return true;
}

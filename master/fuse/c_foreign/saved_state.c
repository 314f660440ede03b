/* In the place of saved states: those of FMUs of other tools are not within the memory that is copied. */

#include "saved_state.h"

static bool refuse_state(const Instance *instance) {
    return refuse(instance, "FMU state: not supported by a system with FMUs of other tools");
}

bool save_state(const Instance *instance, void **state) {
    (void)state;
    return refuse_state(instance);
}

bool restore_state(Instance *instance, const void *state) {
    (void)state;
    return refuse_state(instance);
}

void free_state(void **state) {
    (void)state;
}

size_t serialised_size(void) {
    return 0;
}

bool serialise_state(const Instance *instance, const void *state, void *bytes, size_t size) {
    (void)state, (void)bytes, (void)size;
    return refuse_state(instance);
}

bool deserialise_state(const Instance *instance, const void *bytes, size_t size, void **state) {
    (void)bytes, (void)size, (void)state;
    return refuse_state(instance);
}

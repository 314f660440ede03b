#include "opened.h"

Instance *opened(Instance *instance, const char *resources) {
    Text message = {.length = 0};
    if (system_open(&instance->now.memory, resources, &message)) {
        return instance;
    }
    refuse_text(instance, &message);
    instance_free(instance);
    return NULL;
}

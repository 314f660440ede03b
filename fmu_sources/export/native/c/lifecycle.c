#include "lifecycle.h"

#include <math.h>
#include <string.h>

const char *instantiation_problem(const char *name, const char *guid) {
    if (name == NULL || name[0] == '\0') {
        return "instance name: got none, expected a text";
    }
    if (guid == NULL || strcmp(guid, MODEL_GUID) != 0) {
        return "GUID or instantiation token: not that of this binary, expected " MODEL_GUID;
    }
    return NULL;
}

bool enter_initialisation(Instance *instance, const char *function, double start_time) {
    if (!allow(instance, function, INSTANTIATED)) {
        return false;
    }
    if (!isfinite(start_time)) {
        return refuse(instance, "%s: start time not finite, expected a finite number", function);
    }
    instance->now.time = start_time;
    instance->now.phase = INITIALISING;
    instance->is_preview_valid = false;
    return true;
}

bool exit_initialisation(Instance *instance, const char *function) {
    if (!allow(instance, function, INITIALISING) || instance_readable(instance) == NULL) {
        return false;
    }
    instance->now = instance->preview;
    instance->now.phase = STEPPING;
    return true;
}

bool terminate(Instance *instance, const char *function) {
    if (!allow(instance, function, STEPPING | FAILED)) {
        return false;
    }
    instance->now.phase = TERMINATED;
    return true;
}

bool refuse_missing(const Instance *instance, const char *function, size_t n) {
    return refuse(instance, "%s: got no array, expected one of %lu elements", function, (unsigned long)n);
}

bool check_lengths(const Instance *instance, const char *function, size_t expected, size_t got) {
    if (got != expected) {
        return refuse(instance, "%s: wrong number of values, got %lu, expected %lu", function,
                      (unsigned long)got, (unsigned long)expected);
    }
    return true;
}

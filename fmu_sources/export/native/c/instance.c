#include "instance.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "equations.h"
#include "rules.h"

static const char *phase_name(int phase) {
    switch (phase) {
    case INSTANTIATED:
        return "instantiated";
    case INITIALISING:
        return "initialising";
    case STEPPING:
        return "stepping";
    case TERMINATED:
        return "terminated";
    default:
        return "failed";
    }
}

Instance *instance_create(const char *name) {
    Instance *instance = calloc(1, sizeof *instance);
    if (instance == NULL) {
        return NULL;
    }
    instance->name = malloc(strlen(name) + 1);
    if (instance->name == NULL) {
        free(instance);
        return NULL;
    }
    strcpy(instance->name, name);
    instance->cut.h = NAN; /* no step is as long as this one */
    instance_reset(instance);
    return instance;
}

void instance_free(Instance *instance) {
    if (instance != NULL) {
        free(instance->name);
        free(instance);
    }
}

void instance_reset(Instance *instance) {
    Data *now = &instance->now;
    for (int i = 0; i < N_VARIABLES; i++) {
        now->values[i] = model_variables[i].start;
    }
    remember_inputs(now);
    now->time = 0.0;
    now->phase = INSTANTIATED;
    now->is_unchecked = 0;
    instance->is_preview_valid = false;
}

bool refuse_text(const Instance *instance, const Text *text) {
    instance->log(instance, text->at);
    return false;
}

bool refuse(const Instance *instance, const char *format, ...) {
    char message[512];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(message, sizeof message, format, arguments);
    va_end(arguments);
    instance->log(instance, message);
    return false;
}

static void append_phases(Text *text, int phases) {
    const char *separator = "";
    for (int phase = INSTANTIATED; phase <= FAILED; phase *= 2) {
        if (phases & phase) {
            text_append(text, "%s%s", separator, phase_name(phase));
            separator = " or ";
        }
    }
}

bool refuse_phase(const Instance *instance, const char *function, int phases) {
    Text text = {.length = 0};
    text_append(&text, "%s: call not allowed now, got it while %s, expected it while ", function,
                phase_name(instance->now.phase));
    append_phases(&text, phases);
    return refuse_text(instance, &text);
}

bool instance_initialise(const Instance *instance, Data *data) {
    if (!check_rules(instance, data)) {
        return false;
    }
    apply_initial(data);
    remember_inputs(data);
    apply_outputs(data);
    return check_results(instance, data);
}

const Data *instance_readable(Instance *instance) {
    if (instance->now.phase != INITIALISING) {
        return &instance->now;
    }
    if (!instance->is_preview_valid) {
        instance->preview = instance->now;
        if (!instance_initialise(instance, &instance->preview)) {
            return NULL;
        }
        instance->is_preview_valid = true;
    }
    return &instance->preview;
}

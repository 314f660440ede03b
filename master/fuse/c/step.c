#include "step.h"

#include <math.h>

#include "rules.h"
#include "system.h"

static const double RELATIVE_TOLERANCE = 1e-9;
static const double MOST_TICKS = 1e9; /* more is a wrong number somewhere, and would take for ever */

static RARE bool refuse_step(const Instance *instance, const char *what, double got, const char *expected,
                             double value) {
    Text text = {.length = 0};
    text_append(&text, "%s, got ", what);
    text_append_number(&text, got);
    text_append(&text, " s, expected %s ", expected);
    text_append_number(&text, value);
    text_append(&text, " s");
    return refuse_text(instance, &text);
}

/* Ticks of the system in a step of h [s]: 0 with a message if they are not an integer. */
static long ticks_of(const Instance *instance, double t, double h) {
    const double now = instance->now.time;
    if (!(h > 0.0) || !isfinite(t + h)) {
        refuse_step(instance, "communication step: not a positive number", h, "above", 0.0);
        return 0;
    }
    if (!(fabs(t - now) <= RELATIVE_TOLERANCE * (fabs(now) + h))) {
        refuse_step(instance, "communication point: not where the last step ended", t, "about", now);
        return 0;
    }
    if (h == STEP_SIZE) {
        return 1; /* as a rule, and without a division */
    }
    const double n = nearbyint(h / STEP_SIZE);
    if (!(n >= 1.0) || n > MOST_TICKS || fabs(n * STEP_SIZE - h) > RELATIVE_TOLERANCE * h) {
        refuse_step(instance, "communication step: not a multiple of the system's step", h, "a multiple of",
                    STEP_SIZE);
        return 0;
    }
    return (long)n;
}

bool instance_step(Instance *instance, double t, double h) {
    Data *data = &instance->now;
    Memory *memory = &data->memory;
    if (!are_inputs_well(data)) {
        if (!check_inputs(instance, data)) {
            return false;
        }
        system_take_parameters(memory, data->values);
    }
    const long n = ticks_of(instance, t, h);
    if (n == 0) {
        return false;
    }
    system_attach(memory);
    system_take_inputs(memory, data->values);
    for (long i = 0; i < n; i++) {
#ifdef N_EVENTS
        system_play(memory, data->values);
#endif
        if (!system_tick(memory)) {
            data->phase = FAILED;
            return refuse_text(instance, &memory->message);
        }
    }
    data->time = t + h;
    system_publish(memory, data->values);
    return true;
}

#include "step.h"

#include <math.h>

#include "equations.h"
#include "integrate.h"
#include "rules.h"

static const double RELATIVE_TOLERANCE = 1e-9;

static bool refuse_step(const Instance *instance, const char *what, double got, const char *expected,
                        double value) {
    Text text = {.length = 0};
    text_append(&text, "%s, got ", what);
    text_append_number(&text, got);
    text_append(&text, " s, expected %s ", expected);
    text_append_number(&text, value);
    text_append(&text, " s");
    return refuse_text(instance, &text);
}

static bool check_step(const Instance *instance, double t, double h) {
    const double now = instance->now.time;
    if (!(h > 0.0) || !isfinite(t + h)) {
        return refuse_step(instance, "communication step: not a positive number", h, "above", 0.0);
    }
    if (!(fabs(t - now) <= RELATIVE_TOLERANCE * (fabs(now) + h))) {
        return refuse_step(instance, "communication point: not where the last step ended", t, "about",
                           now);
    }
    return true;
}

/* Sampling periods in a step of h [s]: 0 if they are not a whole number or too many to count. */
static int n_samples(double h, double period) {
    const double n = nearbyint(h / period);
    const bool is_whole = n >= 1.0 && fabs(n * period - h) <= RELATIVE_TOLERANCE * h;
    return is_whole && n <= 1e9 ? (int)n : 0;
}

static bool refuse_multiple(const Instance *instance, double h, double period) {
    Text text = {.length = 0};
    text_append(&text, "communication step: not a multiple of %s",
                model_variables[PLACE(SAMPLE_TIME)].name);
    return refuse_step(instance, text.at, h, "a multiple of", period);
}

static void restart(Data *data) {
    for (int i = 0; i < N_RESTARTING; i++) {
        data->values[model_restarting[i]] = model_variables[model_restarting[i]].start;
    }
}

static void advance(Data *data, double t, double h, int n, double period) {
    data->time = t + h;
    restart(data);
    for (int i = 0; i < n; i++) {
        const double start = t + i * period;
        if (N_STATES > N_CONTINUOUS) {
            apply_update(data, start);
        }
        if (N_CONTINUOUS > 0) {
            const Span span = {start, period, (double)i / n, 1.0 / n};
            integrate(data, &span);
        }
        if (i + 1 < n && has_fault(data, start + period)) {
            data->time = start + period;
            break;
        }
    }
    remember_inputs(data);
    apply_outputs(data);
}

bool instance_step(Instance *instance, double t, double h) {
    Data *data = &instance->now;
    if (!check_inputs(instance, data) || !check_step(instance, t, h)) {
        return false;
    }
    const bool is_sampled = SAMPLE_TIME >= 0;
    const double period = is_sampled ? data->values[PLACE(SAMPLE_TIME)] : h;
    const int n = is_sampled ? n_samples(h, period) : 1;
    if (n == 0) {
        return refuse_multiple(instance, h, period);
    }
    if (N_CONTINUOUS > 0 && n_substeps(period) < 0) {
        return refuse_step(instance, "communication step: too long", h, "substeps of", LONGEST_SUBSTEP);
    }
    advance(data, t, h, n, period);
    if (!check_results(instance, data)) {
        data->phase = FAILED;
        return false;
    }
    return true;
}

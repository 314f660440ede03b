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

/* Whether a step of h from t begins where the last one ended. */
static inline bool follows(double now, double t, double h) {
    return fabs(t - now) <= RELATIVE_TOLERANCE * (fabs(now) + h) && isfinite(t + h);
}

static bool check_step(const Instance *instance, double t, double h) {
    if (!(h > 0.0) || !isfinite(t + h)) {
        return refuse_step(instance, "communication step: not a positive number", h, "above", 0.0);
    }
    if (!follows(instance->now.time, t, h)) {
        return refuse_step(instance, "communication point: not where the last step ended", t, "about",
                           instance->now.time);
    }
    return true;
}

/* Sampling periods in a step of h [s]: 0 if they are not an integer, more than MOST_SAMPLES if too many. */
static int n_samples(double h, double period) {
    if (h == period) {
        return 1; /* as a rule, and without a division */
    }
    const double n = h / period;
    if (!(n < MOST_SAMPLES + 0.5)) {
        return MOST_SAMPLES + 1;
    }
    const int nearest = (int)(n + 0.5);
    return fabs(nearest * period - h) <= RELATIVE_TOLERANCE * h ? nearest : 0;
}

static bool refuse_multiple(const Instance *instance, double h, double period) {
    Text text = {.length = 0};
    text_append(&text, "communication step: not a multiple of %s",
                model_variables[PLACE(SAMPLE_TIME)].name);
    return refuse_step(instance, text.at, h, "a multiple of", period);
}

/* A step that never ends is a wrong number somewhere, in the step or in the sampling period. */
static bool refuse_long(const Instance *instance, const char *what, double h, int most, const char *parts,
                        double length) {
    Text expected = {.length = 0};
    text_append(&expected, "at most %d %s of", most, parts);
    return refuse_step(instance, what, h, expected.at, length);
}

static bool refuse_samples(const Instance *instance, double h, double period) {
    Text what = {.length = 0};
    text_append(&what, "communication step: too long for %s", model_variables[PLACE(SAMPLE_TIME)].name);
    return refuse_long(instance, what.at, h, MOST_SAMPLES, "sampling periods", period);
}

static bool cut_step(Instance *instance, double h) {
    const bool is_sampled = SAMPLE_TIME >= 0;
    const double period = is_sampled ? instance->now.values[PLACE(SAMPLE_TIME)] : h;
    const int n = is_sampled ? n_samples(h, period) : 1;
    if (n > MOST_SAMPLES) {
        return refuse_samples(instance, h, period);
    }
    if (n == 0) {
        return refuse_multiple(instance, h, period);
    }
    const int n_parts = N_CONTINUOUS > 0 ? n_substeps(period) : 1;
    if (n_parts > MOST_SUBSTEPS / n) {
        return refuse_long(instance, "communication step: too long", h, MOST_SUBSTEPS, "substeps",
                           LONGEST_SUBSTEP);
    }
    instance->cut = (Cut){h, period, n, n_parts, period / n_parts};
    return true;
}

/* Whether `prepare` would find nothing wrong and cut the step as the last one. */
static inline bool is_like_last(const Instance *instance, double t, double h) {
    const Data *data = &instance->now;
    const bool is_as_long = h == instance->cut.h &&
                            (SAMPLE_TIME < 0 || data->values[PLACE(SAMPLE_TIME)] == instance->cut.period);
    return is_as_long && are_inputs_well(data) && follows(data->time, t, h);
}

static RARE bool prepare(Instance *instance, double t, double h) {
    return check_inputs(instance, &instance->now) && check_step(instance, t, h) && cut_step(instance, h);
}

static void restart(Data *data) {
    for (int i = 0; i < N_RESTARTING; i++) {
        data->values[model_restarting[i]] = model_variables[model_restarting[i]].start;
    }
}

static inline void advance(Data *data, double t, double h, const Cut *cut) {
    const int n = SAMPLE_TIME >= 0 ? cut->n : 1;
    data->time = t + h;
    restart(data);
    for (int i = 0; i < n; i++) {
        const double start = t + i * cut->period;
        if (N_STATES > N_CONTINUOUS) {
            apply_update(data, start);
        }
        if (N_CONTINUOUS > 0) {
            const Span span = {start, cut->substep, cut->n_substeps, (double)i / n, 1.0 / n};
            integrate(data, &span);
        }
        if (i + 1 < n && has_fault(data, start + cut->period)) {
            data->time = start + cut->period;
            break;
        }
    }
    remember_inputs(data);
    apply_outputs(data);
}

bool instance_step(Instance *instance, double t, double h) {
    Data *data = &instance->now;
    if (!is_like_last(instance, t, h) && !prepare(instance, t, h)) {
        return false;
    }
    advance(data, t, h, &instance->cut);
    if (!are_results_well(data) && !check_results(instance, data)) {
        data->phase = FAILED;
        return false;
    }
    return true;
}

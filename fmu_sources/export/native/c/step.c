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

/* How a communication step is cut: n sampling periods, each in equal substeps. */
typedef struct {
    int n;
    double period;
    int n_substeps;
} Cut;

/* Sampling periods in a step of h [s]: 0 if they are not a whole number or too many to count. */
static int n_samples(double h, double period) {
    if (h == period) {
        return 1; /* as a rule, and without a division */
    }
    const double n = h / period;
    if (!(n <= 1e9)) {
        return 0;
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

static bool cut_step(const Instance *instance, double h, Cut *cut) {
    const bool is_sampled = SAMPLE_TIME >= 0;
    cut->period = is_sampled ? instance->now.values[PLACE(SAMPLE_TIME)] : h;
    cut->n = is_sampled ? n_samples(h, cut->period) : 1;
    if (cut->n == 0) {
        return refuse_multiple(instance, h, cut->period);
    }
    cut->n_substeps = N_CONTINUOUS > 0 ? n_substeps(cut->period) : 1;
    if (cut->n_substeps == 0) {
        return refuse_step(instance, "communication step: too long", h, "substeps of", LONGEST_SUBSTEP);
    }
    return true;
}

static void restart(Data *data) {
    for (int i = 0; i < N_RESTARTING; i++) {
        data->values[model_restarting[i]] = model_variables[model_restarting[i]].start;
    }
}

static void advance(Data *data, double t, double h, const Cut *cut) {
    data->time = t + h;
    restart(data);
    for (int i = 0; i < cut->n; i++) {
        const double start = t + i * cut->period;
        if (N_STATES > N_CONTINUOUS) {
            apply_update(data, start);
        }
        if (N_CONTINUOUS > 0) {
            const Span span = {start, cut->period, cut->n_substeps, (double)i / cut->n, 1.0 / cut->n};
            integrate(data, &span);
        }
        if (i + 1 < cut->n && has_fault(data, start + cut->period)) {
            data->time = start + cut->period;
            break;
        }
    }
    remember_inputs(data);
    apply_outputs(data);
}

bool instance_step(Instance *instance, double t, double h) {
    Data *data = &instance->now;
    Cut cut;
    if (!check_inputs(instance, data) || !check_step(instance, t, h) || !cut_step(instance, h, &cut)) {
        return false;
    }
    advance(data, t, h, &cut);
    if (!check_results(instance, data)) {
        data->phase = FAILED;
        return false;
    }
    return true;
}

#include "rules.h"

#include <math.h>

static bool keeps(const Rule *rule, double value) {
    switch (rule->kind) {
    case RULE_ABOVE:
        return value > rule->bound;
    case RULE_AT_LEAST:
        return value >= rule->bound;
    case RULE_AT_MOST:
        return value <= rule->bound;
    default:
        for (int i = 0; i < rule->n_items; i++) {
            if (value == rule->items[i]) {
                return true;
            }
        }
        return false;
    }
}

static const char *broken_rule(const Variable *variable, double value) {
    if (!isfinite(value)) {
        return "a finite number";
    }
    for (int i = 0; i < variable->n_rules; i++) {
        if (!keeps(&variable->rules[i], value)) {
            return variable->rules[i].text;
        }
    }
    return NULL;
}

static void append_finding(Text *text, const Variable *variable, const char *what, double value,
                           const char *expected) {
    text_append(text, "%s%s: %s, got ", text->length > 0 ? "; " : "", variable->name, what);
    text_append_value(text, variable, value);
    text_append(text, ", expected %s", expected);
}

bool check_rules(const Instance *instance, Data *data) {
    Text text = {.length = 0};
    for (int i = 0; i < FIRST_STATE; i++) {
        const char *expected = broken_rule(&model_variables[i], data->values[i]);
        if (expected != NULL) {
            append_finding(&text, &model_variables[i], "value not allowed", data->values[i], expected);
        }
    }
    if (text.length > 0) {
        return refuse_text(instance, &text);
    }
    data->is_unchecked = 0;
    return true;
}

/* The first value from a place to the one before another that is not finite, or the latter. */
static int first_not_finite(const Data *data, int first, int behind) {
    while (first < behind && isfinite(data->values[first])) {
        first++;
    }
    return first;
}

bool check_inputs(const Instance *instance, Data *data) {
    const bool are_finite = first_not_finite(data, FIRST_INPUT, FIRST_STATE) == FIRST_STATE;
    return (are_finite && !data->is_unchecked) || check_rules(instance, data);
}

/* A sum is finite only if all its terms are; finite ones add up beyond all numbers in a very rare case.
   Eight sums next to each other, which vectors add at once. */
static inline bool is_sum_finite(const double *values, int n) {
    enum { N_SUMS = 8 };
    const int n_whole = n / N_SUMS * N_SUMS;
    double sum = 0.0;
    if (n_whole > 0) {
        double sums[N_SUMS] = {0.0};
        for (int i = 0; i < n_whole; i += N_SUMS) {
            for (int j = 0; j < N_SUMS; j++) {
                sums[j] += values[i + j];
            }
        }
        sum = (sums[0] + sums[1]) + (sums[2] + sums[3]) + (sums[4] + sums[5]) + (sums[6] + sums[7]);
    }
    for (int i = n_whole; i < n; i++) {
        sum += values[i];
    }
    return isfinite(sum);
}

bool are_inputs_well(const Data *data) {
    return !data->is_unchecked && (N_INPUTS == 0 || is_sum_finite(data->values + FIRST_INPUT, N_INPUTS));
}

bool are_results_well(const Data *data) {
    return is_sum_finite(data->values + FIRST_STATE, N_STATES + N_OUTPUTS) && !has_fault(data, data->time);
}

bool has_fault(const Data *data, double t) {
    const double *values = data->values;
    double faults[ROOM(N_FAULTS)];
    model_faults(t, values + FIRST_STATE, values + FIRST_INPUT, values, faults);
    for (int i = 0; i < N_FAULTS; i++) {
        if (faults[i] != 0.0) {
            return true;
        }
    }
    return false;
}

static bool refuse_faults(const Instance *instance, const Data *data) {
    const double *values = data->values;
    double faults[ROOM(N_FAULTS)];
    Text text = {.length = 0};
    model_faults(data->time, values + FIRST_STATE, values + FIRST_INPUT, values, faults);
    for (int i = 0; i < N_FAULTS; i++) {
        if (faults[i] != 0.0) {
            const Fault *fault = &model_fault_texts[i];
            const Variable *variable = &model_variables[fault->reference];
            append_finding(&text, variable, fault->text, values[fault->reference], fault->expected);
        }
    }
    return refuse_text(instance, &text);
}

static bool check_faults(const Instance *instance, const Data *data) {
    return !has_fault(data, data->time) || refuse_faults(instance, data);
}

static bool refuse_result(const Instance *instance, const Data *data, int reference) {
    Text text = {.length = 0};
    text_append(&text, "%s: value not finite at t=", model_variables[reference].name);
    text_append_number(&text, data->time);
    text_append(&text, " s, got ");
    text_append_value(&text, &model_variables[reference], data->values[reference]);
    text_append(&text, ", expected a finite number");
    return refuse_text(instance, &text);
}

static bool check_finite(const Instance *instance, const Data *data) {
    const int first = first_not_finite(data, FIRST_STATE, N_VARIABLES);
    return first == N_VARIABLES || refuse_result(instance, data, first);
}

bool check_results(const Instance *instance, const Data *data) {
    return check_faults(instance, data) && check_finite(instance, data);
}

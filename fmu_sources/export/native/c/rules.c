#include "rules.h"

#include <math.h>
#include <stdint.h>
#include <string.h>

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

/* Infinities and NaNs have an exponent of all ones: one more carries into the sign. A loop without a branch. */
static bool are_finite(const double *values, int n) {
    const uint64_t magnitude = UINT64_MAX >> 1, one_exponent = (uint64_t)1 << 52;
    uint64_t carried = 0;
    for (int i = 0; i < n; i++) {
        uint64_t bits;
        memcpy(&bits, &values[i], sizeof bits);
        carried |= (bits & magnitude) + one_exponent;
    }
    return carried <= magnitude;
}

bool check_inputs(const Instance *instance, Data *data) {
    const bool is_well = are_finite(data->values + FIRST_INPUT, N_INPUTS) && !data->is_unchecked;
    return is_well || check_rules(instance, data);
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
    if (are_finite(data->values + FIRST_STATE, N_STATES + N_OUTPUTS)) {
        return true;
    }
    int first = FIRST_STATE;
    while (isfinite(data->values[first])) {
        first++;
    }
    return refuse_result(instance, data, first);
}

bool check_results(const Instance *instance, const Data *data) {
    return check_faults(instance, data) && check_finite(instance, data);
}

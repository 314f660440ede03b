/* What the generated schedule is made of. */

#ifndef SCHEDULE_H
#define SCHEDULE_H

#include <limits.h>
#include <math.h>
#include <string.h>

#include "system.h"

/* Not every schedule has integers and iterated groups. */
#if defined(__GNUC__)
#define MAYBE_UNUSED __attribute__((unused))
#else
#define MAYBE_UNUSED
#endif

/* What a wire sent last while initial values settle. */
typedef struct {
    double value;
    bool is_known;
} Sent;

/* The wire of an iterated group whose ends differ most, measured by its tolerance. */
typedef struct {
    const char *wire;
    double ratio;
    double residual;
    double tolerance;
} Residual;

/* Integers as getters of FMI 2.0 (and of Int32), and of Int64, give them. */
static inline double integer_of(double value) {
    return value > INT_MIN && value < INT_MAX ? (double)(int)value : 0.0;
}

static inline double long_of(double value) {
    return value > -1e15 && value < 1e15 ? (double)(long long)value : 0.0;
}

static inline void fill(double *cells, int n, double value) {
    for (int i = 0; i < n; i++) {
        cells[i] = value;
    }
}

/* Whether a wire sends another value than before; it has moved if it does so by more than its tolerance. */
static inline bool is_new(Sent *sent, double value, double tolerance, bool *has_moved) {
    const Sent before = *sent;
    if (before.is_known && value == before.value) {
        return false;
    }
    *sent = (Sent){value, true};
    if (!before.is_known || fabs(value - before.value) > tolerance) {
        *has_moved = true;
    }
    return true;
}

static inline void compare(Residual *worst, double sent, double taken, double tolerance, const char *wire) {
    const double residual = fabs(sent - taken);
    const double ratio = residual / tolerance;
    if (!(ratio <= worst->ratio)) {
        *worst = (Residual){wire, ratio, residual, tolerance};
    }
}

static RARE void say(Text *message, const char *instance, const char *text) {
    text_append(message, "%s%s: %s", message->length > 0 ? "; " : "", instance, text);
}

MAYBE_UNUSED static RARE bool refuse_misfit(Memory *memory, const char *signal, const char *type, double value) {
    text_append(&memory->message, "%s: value does not fit %s, got ", signal, type);
    text_append_number(&memory->message, value);
    return false;
}

MAYBE_UNUSED static RARE bool refuse_residual(Memory *memory, const Residual *worst) {
    text_append(&memory->message, "the iteration over %s does not converge, got a residual of ", worst->wire);
    text_append_number(&memory->message, worst->residual);
    text_append(&memory->message, ", expected at most ");
    text_append_number(&memory->message, worst->tolerance);
    return false;
}

MAYBE_UNUSED static RARE bool refuse_unsettled(Memory *memory) {
    text_append(&memory->message, "initial values do not settle, expected no algebraic loop at the start or one "
                                  "that an iterated group solves");
    return false;
}

#endif

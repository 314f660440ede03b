/* The same operations in the same order as fmu_sources/framework/integrate.py, so that both agree bit for bit. */

#include "integrate.h"

#include <string.h>

enum { HOLD_NEW = 2, HOLD_OLD = 3 };

typedef struct {
    const Data *data;
    const Span *span;
    double hold;
} Stages;

int n_substeps(double period) {
    const double n = period / LONGEST_SUBSTEP - 1e-9;
    if (!(n <= MOST_SUBSTEPS)) {
        return MOST_SUBSTEPS + 1;
    }
    const int whole = (int)n;
    return n <= 1.0 ? 1 : whole + (whole < n); /* rounded up */
}

static inline const double *inputs_at(const Stages *stages, double share, double u[ROOM(N_INPUTS)]) {
    const double *old = stages->data->previous_inputs;
    const double *new = stages->data->values + FIRST_INPUT;
    if (stages->hold == HOLD_NEW) {
        return new;
    }
    if (stages->hold == HOLD_OLD) {
        return old;
    }
    for (int i = 0; i < N_INPUTS; i++) {
        u[i] = old[i] + share * (new[i] - old[i]);
    }
    return u;
}

/* k = h der(x) at a place counted in substeps. */
static inline void slope(const Stages *stages, double place, const double *x, double k[ROOM(N_CONTINUOUS)]) {
    const Span *span = stages->span;
    double u[ROOM(N_INPUTS)];
    const double share = span->first + span->share * (place / span->n);
    const double t = span->t + place * span->h;
    model_derivatives(t, x, inputs_at(stages, share, u), stages->data->values, k);
    for (int i = 0; i < N_CONTINUOUS; i++) {
        k[i] = span->h * k[i];
    }
}

/* From x to x, by way of `stage`: all states, of which the sampled ones stay. */
static inline void substep(const Stages *stages, double place, double x[ROOM(N_CONTINUOUS)], double *stage) {
    double k1[ROOM(N_CONTINUOUS)], k2[ROOM(N_CONTINUOUS)];
    double k3[ROOM(N_CONTINUOUS)], k4[ROOM(N_CONTINUOUS)];

    slope(stages, place, stage, k1);
    for (int i = 0; i < N_CONTINUOUS; i++) {
        stage[i] = x[i] + 0.5 * k1[i];
    }
    slope(stages, place + 0.5, stage, k2);
    for (int i = 0; i < N_CONTINUOUS; i++) {
        stage[i] = x[i] + 0.5 * k2[i];
    }
    slope(stages, place + 0.5, stage, k3);
    for (int i = 0; i < N_CONTINUOUS; i++) {
        stage[i] = x[i] + k3[i];
    }
    slope(stages, place + 1.0, stage, k4);
    for (int i = 0; i < N_CONTINUOUS; i++) {
        x[i] = x[i] + (k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i]) / 6.0;
        stage[i] = x[i];
    }
}

void integrate(Data *data, const Span *span) {
    const double hold = INPUT_HOLD < 0 ? HOLD_NEW : data->values[PLACE(INPUT_HOLD)];
    const Stages stages = {data, span, hold};
    double *stage = data->values + FIRST_STATE;
    double x[ROOM(N_CONTINUOUS)]; /* apart from the stages, so that they can stay in registers */
    memcpy(x, stage, N_CONTINUOUS * sizeof *x);
    for (int i = 0; i < span->n; i++) {
        substep(&stages, i, x, stage);
    }
}

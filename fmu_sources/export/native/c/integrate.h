/* Classical Runge-Kutta of order 4 in equal substeps. */

#ifndef INTEGRATE_H
#define INTEGRATE_H

#include "instance.h"

/* The part of a communication step that is integrated: from t over a period, in n substeps of h. */
typedef struct {
    double t;
    double h;
    int n;
    double first; /* share of the communication step at t: 0 at its start */
    double share; /* share of the communication step that `period` is */
} Span;

/* Number of substeps of a period; more than MOST_SUBSTEPS if there are too many to count. */
int n_substeps(double period);

void integrate(Data *data, const Span *span);

#endif

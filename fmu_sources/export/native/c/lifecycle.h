/* What FMI 2.0 and FMI 3.0 have in common: the calls that lead from one phase to the next. */

#ifndef LIFECYCLE_H
#define LIFECYCLE_H

#include <stddef.h>

#include "instance.h"

/* NULL if all is well, else what is wrong with the arguments of instantiation. */
const char *instantiation_problem(const char *name, const char *guid);

bool enter_initialisation(Instance *instance, const char *function, double start_time);
bool exit_initialisation(Instance *instance, const char *function);
bool terminate(Instance *instance, const char *function);

/* Refuse arrays that are missing where they should hold something. */
RARE bool refuse_missing(const Instance *instance, const char *function, size_t n);

static inline bool check_arrays(const Instance *instance, const char *function, size_t n, const void *a,
                                const void *b) {
    return n == 0 || (a != NULL && b != NULL) || refuse_missing(instance, function, n);
}

/* Refuse two array lengths that should be the same. */
bool check_lengths(const Instance *instance, const char *function, size_t expected, size_t got);

#endif

/* What the wrapper knows of a model: the generated tables and equations. */

#ifndef MODEL_H
#define MODEL_H

#include <stdbool.h>

#include "model_data.h" /* generated: sizes, places, identity */

/* An array must have an element even where the model has none. */
#define ROOM(n) ((n) > 0 ? (n) : 1)

/* A place that is -1 where the model has no such variable, as an index that is never used then. */
#define PLACE(index) ((index) < 0 ? 0 : (index))

/* Where each group starts in the list of all variables; the place there is the value reference. */
enum {
    FIRST_PARAMETER = 0,
    FIRST_INPUT = N_PARAMETERS,
    FIRST_STATE = FIRST_INPUT + N_INPUTS,
    FIRST_OUTPUT = FIRST_STATE + N_STATES,
    N_VARIABLES = FIRST_OUTPUT + N_OUTPUTS
};

typedef enum { ROLE_PARAMETER, ROLE_INPUT, ROLE_STATE, ROLE_OUTPUT } Role;
typedef enum { TYPE_REAL, TYPE_INTEGER, TYPE_ENUMERATION, TYPE_BOOLEAN, TYPE_NONE } Type;
typedef enum { RULE_ABOVE, RULE_AT_LEAST, RULE_AT_MOST, RULE_ONE_OF } RuleKind;

typedef struct {
    RuleKind kind;
    double bound;
    const double *items;
    int n_items;
    const char *text;
} Rule;

typedef struct {
    const char *name;
    const char *unit; /* with a space before it; empty for a pure number */
    Role role;
    Type type;
    bool is_fixed;
    bool is_hidden;
    double start;
    const Rule *rules;
    int n_rules;
} Variable;

/* What ends a run: the variable whose value shows it, what is wrong, what is expected of the value. */
typedef struct {
    int reference;
    const char *text;
    const char *expected;
} Fault;

extern const Variable model_variables[];

/* The types again, a byte a variable, for the calls of every step: TYPE_NONE where a reader may not see
   the variable, where it is not an input. */
extern const unsigned char model_readable[];
extern const unsigned char model_inputs[];

extern const Fault model_fault_texts[];
extern const int model_restarting[]; /* states that begin each communication step at their start value */

/* Equations on t, states x (continuous first), inputs u and parameters p. */
void model_initial(double t, const double *x, const double *u, const double *p, double *new_x);
void model_update(double t, const double *x, const double *u, const double *p, double *new_x);
void model_derivatives(double t, const double *x, const double *u, const double *p, double *der_x);
void model_outputs(double t, const double *x, const double *u, const double *p, double *y);
void model_faults(double t, const double *x, const double *u, const double *p, double *faults);

/* Derivative of the outputs along `seed`, which holds parameters, inputs and states in this order. */
void model_outputs_along(double t, const double *x, const double *u, const double *p,
                         const double *seed, double *der_y);

#endif

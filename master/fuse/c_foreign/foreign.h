/* FMUs of other tools within this one: loaded from its resources, called by the functions of their FMI. */

#ifndef FOREIGN_H
#define FOREIGN_H

#include <stdbool.h>

#include "text.h"

/* In the order of `master.fmi.value_types`. */
typedef enum {
    VALUE_FLOAT64,
    VALUE_FLOAT32,
    VALUE_INT8,
    VALUE_UINT8,
    VALUE_INT16,
    VALUE_UINT16,
    VALUE_INT32,
    VALUE_UINT32,
    VALUE_INT64,
    VALUE_UINT64,
    VALUE_BOOLEAN,
    VALUE_INT_BOOLEAN, /* of FMI 2.0 */
    VALUE_STRING,
    N_VALUE_TYPES
} ValueType;

/* A variable of an FMU: its value reference, and its place among the values that are kept of it here. */
typedef struct {
    unsigned reference;
    ValueType type;
    int place;
} ForeignCell;

/* A start value: that at a place, or where this is -1, a text or a number of its own. One that the system does
   not give is set only if the importer has changed it from `value`. */
typedef struct {
    ForeignCell cell;
    bool is_given;
    double value;
    const char *text;
} ForeignStart;

typedef struct {
    const ForeignCell *at;
    int n;
} ForeignCells;

/* What is known of an FMU before it is loaded. */
typedef struct {
    const char *name;
    const char *folder;  /* in the resources of this FMU */
    const char *library; /* in that folder */
    const char *token;
    int version;
    bool is_alone;    /* one instance a process: it is reset where others are made again */
    bool saves_state; /* within a step, for iterated groups */
    const ForeignStart *starts;
    int n_starts;
    ForeignCells received; /* inputs that connections set before each step */
    ForeignCells open;     /* inputs and tunable parameters that the importer sets */
    ForeignCells sources;  /* outputs that connections read */
    ForeignCells shown;    /* all outputs */
} ForeignFmu;

typedef struct Foreign Foreign;

/* A loaded and instantiated FMU; NULL with a message if there is none. `resources` is what this FMU was told. */
Foreign *foreign_open(const ForeignFmu *fmu, const char *resources, Text *message);
void foreign_close(Foreign *foreign);

/* The name of its instance in the system. */
const char *foreign_name(const Foreign *foreign);

/* What is wrong after a function here returned false. */
const char *foreign_said(const Foreign *foreign);

/* A new instance in initialisation mode, with its start values. */
bool foreign_start(Foreign *foreign, const double *values, double t0);
bool foreign_set(Foreign *foreign, ForeignCell cell, const double *values);
bool foreign_read_sources(Foreign *foreign, double *values);

/* Leave initialisation mode. */
bool foreign_begin(Foreign *foreign, double *values);
bool foreign_step(Foreign *foreign, double *values, double t, double h);
/* Within a step, for iterated groups: what the importer has set is part of the state. */
bool foreign_save(Foreign *foreign, const double *values);
bool foreign_restore(Foreign *foreign);

/* For the importer: the state of the FMU, and what is known of it here, into *kept, which is NULL or an earlier
   one. An FMU of which states are kept is reset where others are made again. */
typedef struct ForeignState ForeignState;
bool foreign_keep(Foreign *foreign, ForeignState **kept);
bool foreign_bring_back(Foreign *foreign, const ForeignState *kept);
void foreign_forget(ForeignState **kept);

#endif

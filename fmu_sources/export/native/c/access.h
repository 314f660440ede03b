/* Reading and writing variables by value reference. */

#ifndef ACCESS_H
#define ACCESS_H

#include "instance.h"

/* A call that touches variables: its name for messages, and the type that it is for. */
typedef struct {
    const char *function;
    Type type;
} Access;

bool read_value(Instance *instance, Access access, unsigned reference, double *value);
bool write_value(Instance *instance, Access access, unsigned reference, double value);

/* The variable behind a reference, NULL (with a message) if there is none that the importer knows. */
const Variable *variable_at(const Instance *instance, const char *function, unsigned reference);

#endif

#ifndef OPENED_H
#define OPENED_H

#include "instance.h"

/* An instance with its FMUs of other tools loaded; NULL, and the instance freed, if one cannot be. */
Instance *opened(Instance *instance, const char *resources);

/* Generated. */
bool system_open(Memory *memory, const char *resources, Text *message);
void system_close(Memory *memory);
Foreign *system_foreign(const Memory *memory, int number); /* below N_FOREIGN */

#endif

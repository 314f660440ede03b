/* What a library for whole runs has next to the system. */

#ifndef RUNS_H
#define RUNS_H

#include "system.h"

/* All outputs of all FMUs after a tick, in the order in which the master records them. */
void system_record(const Memory *memory, double *row);

#endif

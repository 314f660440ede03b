/* The coupled system: its inner FMUs, and the schedule that steps them. */

#ifndef SYSTEM_H
#define SYSTEM_H

#include "instance.h"

/* Let the inner FMUs belong to this memory, wherever it was copied from. */
void system_attach(Memory *memory);

/* From the start values of the fused FMU to initialised inner ones; false with a message in the memory. */
bool system_start(Memory *memory, const double *values, double t0);

/* Hand on what the importer set. */
void system_take_inputs(Memory *memory, const double *values);
void system_take_parameters(Memory *memory, const double *values);

/* Before each step, where there are events: begin and end what is due. */
void system_play(Memory *memory, const double *values);

/* One communication step of the system; false with a message in the memory. */
bool system_tick(Memory *memory);

/* Show states, outputs and connected inputs of the inner FMUs. */
void system_publish(const Memory *memory, double *values);

#endif

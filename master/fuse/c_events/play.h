#ifndef PLAY_H
#define PLAY_H

#include "system.h"

/* Before the first tick: nothing has begun. */
void play_from_the_start(Memory *memory, const double *fallbacks);

/* Over what the importer set: what the acting events set, the one that began last at the end. */
void overlay(Memory *memory);

/* Pass a value through a channel in tick k, its past in n cells: delay, jitter, offset, freeze, drop. */
double through_channel(double *channel, double *cells, int n, uint64_t k, double value);

/* Generated: set what an action sets. */
void apply_action(Memory *memory, int action);

#endif

/* What happens to a system during a run: its events, played before each tick as `dockloop run` plays them. */

#ifndef EVENTS_H
#define EVENTS_H

#include <stdbool.h>
#include <stdint.h>

/* What an event does: `sets` a variable of an FMU, or changes some cells of the channel of a connection. */
typedef struct {
    bool sets;
    int channel;
    int n;
    struct {
        int column;
        double number;
    } changes[2];
} Action;

/* An event at a tick, or where this is -1, after a tick whose end fulfils sign * (value - threshold) > 0; taken
   back after n ticks, or where this is -1, never. Its actions are those from `first` to before `after`. */
typedef struct {
    int64_t tick;
    int place;
    double sign;
    double threshold;
    int64_t n_ticks;
    int first;
    int after;
} Event;

/* What has been played so far: `acting` are actions in the order in which they began, `ends` when they end. */
typedef struct {
    bool has_begun[N_EVENTS];
    int n_acting;
    int acting[N_ACTIONS];
    int64_t ends[N_ACTIONS];
} Played;

/* Columns of a channel. */
enum { CHANNEL_MODE, CHANNEL_OFFSET, CHANNEL_DELAY, CHANNEL_JITTER, CHANNEL_FALLBACK, CHANNEL_RANDOM, CHANNEL_DRAWN, CHANNEL_MORE, CHANNEL_HELD, N_CHANNEL_COLUMNS };

/* Generated. */
extern const Action system_actions[N_ACTIONS];
extern const Event system_events[N_EVENTS]; /* those under a condition before those at a time */

#endif

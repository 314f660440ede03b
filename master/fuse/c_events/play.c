#include "play.h"

#include <string.h>

enum { PASS, FREEZE, DROP };

static const int64_t MULTIPLIER = 48271; /* generator of Park and Miller, as in `dockloop run` */
static const int64_t MODULUS = 2147483647;

/* The bytes of a saved state may come from anywhere. */
static void keep_within_bounds(Played *played) {
    bool is_well = played->n_acting >= 0 && played->n_acting <= N_ACTIONS;
    for (int i = 0; is_well && i < played->n_acting; i++) {
        is_well = played->acting[i] >= 0 && played->acting[i] < N_ACTIONS;
    }
    if (!is_well) {
        played->n_acting = 0;
    }
}

static bool is_due(const Memory *memory, const Event *event, int64_t tick) {
    if (event->tick >= 0) {
        return event->tick <= tick;
    }
    return event->sign * (memory->values[event->place] - event->threshold) > 0.0;
}

static void begin(Memory *memory, const Event *event, int64_t tick) {
    Played *const played = &memory->played;
    for (int i = event->first; i < event->after && played->n_acting < N_ACTIONS; i++) {
        const Action *const action = &system_actions[i];
        for (int j = 0; j < action->n; j++) {
            if (action->changes[j].column == CHANNEL_RANDOM) {
                memory->channels[action->channel][CHANNEL_RANDOM] = action->changes[j].number;
            }
        }
        played->acting[played->n_acting] = i;
        played->ends[played->n_acting] = event->n_ticks < 0 ? INT64_MAX : tick + event->n_ticks;
        played->n_acting++;
    }
}

/* Begin what is due: with a tick that is given, or under a condition. */
static bool begin_due(Memory *memory, int64_t tick, bool at_a_time) {
    bool has_begun = false;
    for (int i = 0; i < N_EVENTS; i++) {
        const Event *const event = &system_events[i];
        bool *const done = &memory->played.has_begun[i];
        if ((event->tick >= 0) == at_a_time && !*done && is_due(memory, event, tick)) {
            *done = true;
            begin(memory, event, tick);
            has_begun = true;
        }
    }
    return has_begun;
}

static bool end_due(Played *played, int64_t tick) {
    int n = 0;
    for (int i = 0; i < played->n_acting; i++) {
        if (played->ends[i] > tick) {
            played->acting[n] = played->acting[i];
            played->ends[n] = played->ends[i];
            n++;
        }
    }
    const bool has_ended = n < played->n_acting;
    played->n_acting = n;
    return has_ended;
}

/* What all acting events make of the channels, in the order in which they began. */
static void change_channels(Memory *memory) {
    for (int i = 0; i < N_CHANNELS; i++) {
        double *const channel = memory->channels[i];
        channel[CHANNEL_MODE] = PASS;
        channel[CHANNEL_OFFSET] = channel[CHANNEL_DELAY] = channel[CHANNEL_JITTER] = 0.0;
    }
    for (int i = 0; i < memory->played.n_acting; i++) {
        const Action *const action = &system_actions[memory->played.acting[i]];
        for (int j = 0; j < action->n; j++) {
            if (action->changes[j].column != CHANNEL_RANDOM) {
                memory->channels[action->channel][action->changes[j].column] = action->changes[j].number;
            }
        }
    }
}

void system_play(Memory *memory, const double *values) {
    const int64_t tick = (int64_t)memory->tick;
    keep_within_bounds(&memory->played);
    const bool was_fulfilled = begin_due(memory, tick, false);
    const bool has_ended = end_due(&memory->played, tick);
    const bool is_time = begin_due(memory, tick, true);
    if (was_fulfilled || has_ended || is_time) {
        change_channels(memory);
        system_take_parameters(memory, values);
        system_take_inputs(memory, values);
    }
}

void play_from_the_start(Memory *memory, const double *fallbacks) {
    memset(&memory->played, 0, sizeof memory->played);
    memset(memory->channels, 0, sizeof memory->channels);
    for (int i = 0; i < N_CHANNELS; i++) {
        memory->channels[i][CHANNEL_FALLBACK] = fallbacks[i];
        memory->channels[i][CHANNEL_RANDOM] = 1.0;
        memory->channels[i][CHANNEL_DRAWN] = -1.0;
    }
}

void overlay(Memory *memory) {
    keep_within_bounds(&memory->played);
    for (int i = 0; i < memory->played.n_acting; i++) {
        if (system_actions[memory->played.acting[i]].sets) {
            apply_action(memory, memory->played.acting[i]);
        }
    }
}

double through_channel(double *channel, double *cells, int n, uint64_t k, double value) {
    cells[k % (uint64_t)n] = value;
    int64_t age = (int64_t)channel[CHANNEL_DELAY];
    if (channel[CHANNEL_JITTER] > 0.0) {
        if (channel[CHANNEL_DRAWN] != (double)k) { /* once a tick, however often an iterated group passes here */
            const int64_t state = (MULTIPLIER * (int64_t)channel[CHANNEL_RANDOM]) % MODULUS;
            channel[CHANNEL_RANDOM] = (double)state;
            channel[CHANNEL_DRAWN] = (double)k;
            channel[CHANNEL_MORE] = (double)(state % ((int64_t)channel[CHANNEL_JITTER] + 1));
        }
        age += (int64_t)channel[CHANNEL_MORE];
    }
    if (channel[CHANNEL_MODE] == FREEZE) {
        return channel[CHANNEL_HELD];
    }
    if (channel[CHANNEL_MODE] == DROP) {
        return channel[CHANNEL_FALLBACK];
    }
    int64_t at = ((int64_t)k - age) % n;
    if (at < 0) {
        at += n;
    }
    channel[CHANNEL_HELD] = cells[at] + channel[CHANNEL_OFFSET];
    return channel[CHANNEL_HELD];
}

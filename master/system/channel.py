"""What a scenario may do to the value of a connection on its way."""

from __future__ import annotations

from enum import IntEnum


class Mode(IntEnum):
    """What a channel does with its value: pass it on, hold the last one, or give the start value."""

    PASS = 0
    FREEZE = 1
    DROP = 2


class Channel(IntEnum):
    """Columns of a row of `channels`, the state of one channel in the machine's memory."""

    MODE = 0
    OFFSET = 1
    DELAY = 2
    JITTER = 3
    FALLBACK = 4
    RANDOM = 5
    DRAWN = 6
    MORE = 7
    HELD = 8


# The same as integers, for compiled code: enumerations there cost seconds of compilation.
PASS, FREEZE, DROP = map(int, Mode)
MODE, OFFSET, DELAY, JITTER, FALLBACK, RANDOM, DRAWN, MORE, HELD = map(int, Channel)

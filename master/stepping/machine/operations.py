"""Operations with a rule of their own: channels, iteration, and what an FMU 3.0 asks for in a step."""

from __future__ import annotations

from enum import IntEnum
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from master.coupling.extrapolation import one_step_on
from master.fmi.native import calls
from master.fmi.native.cells import load, store
from master.fmi.native.jit import inlined, inner
from master.fmi.value_types import FLOAT64, UINT8
from master.system.channel import (
    DELAY,
    DRAWN,
    DROP,
    FALLBACK,
    FREEZE,
    HELD,
    JITTER,
    MODE,
    MORE,
    OFFSET,
    RANDOM,
)

from .program import Memory

Floats = NDArray[np.float64]

inner(one_step_on)  # compiled here: who only reads a configuration does not wait for numba


class Deviation(IntEnum):
    """What is wrong although no function said so: statuses beyond the 32 bits that an FMU can return."""

    STOOD_STILL = 1 << 32
    WANTED_EVENTS = (1 << 32) + 1
    ENDED_WITHIN = (1 << 32) + 2
    MISFIT = (1 << 32) + 3
    NO_TIME = (1 << 32) + 4
    TOO_MANY_RETURNS = (1 << 32) + 5
    NO_STATE = (1 << 32) + 6


STOOD_STILL, WANTED_EVENTS, ENDED_WITHIN, MISFIT, NO_TIME, TOO_MANY_RETURNS, NO_STATE = map(int, Deviation)
MOST_RETURNS = 10**6  # early returns from one step; more would look as if the run had stopped

_MULTIPLIER, _MODULUS = 48271, 2147483647
_EVENTS, _END, _EARLY, _TIME = range(4)  # cells of 8 bytes of the answers to a step of FMI 3.0


class Answer(NamedTuple):
    """Status of a step and whether the FMU asks for the end of the simulation."""

    status: int
    asks_for_end: bool


class LoopDecision(NamedTuple):
    """
    What follows a CHECK.

    `operation`: after which to go on; `closed`: whether the wires agree or the passes are used up; `worst`:
    row of the worst wire if they are used up, else -1.
    """

    operation: int
    closed: bool
    worst: int


@inlined
def is_bad(status: int) -> bool:
    """Whether a status ends the run: all but OK (0) and warning (1), negative ones and unknown ones too."""
    return (status & ~1) != 0  # one comparison, three times for each FMU and tick


@inner
def extrapolate(rings: Floats, first: int, order: int, value: float) -> Any:
    """Value one step on; the last values are kept in `rings` from the cell `first` on."""
    last, before = rings[first], 0.0
    rings[first] = value
    if order > 1:
        before = rings[first + 1]
        rings[first + 1] = last
    return one_step_on(order, value, last, before)


@inner
def asks(answers: int) -> bool:
    """Whether an FMU 3.0 asks for anything after a step, or reached no time: see `handle_step_flags`."""
    time = load(answers, _TIME, FLOAT64)
    flags = load(answers, 0, UINT8) + load(answers, 8, UINT8) + load(answers, 16, UINT8)
    return flags > 0.0 or time != time


@inner
def handle_step_flags(component: int, do_step: int, t: float, h: float, answers: int, status: int) -> Answer:
    """
    Do what an FMU 3.0 asked for in the step (t, h) [s]: after an early return, step on to the end.

    `answers` is the address of four cells of 8 bytes: event mode, end of the simulation, early return, time
    reached [s].

    Returns:
        The status is STOOD_STILL if it returned without making progress, TOO_MANY_RETURNS if it returned more
        often than MOST_RETURNS, NO_TIME if the time that it reached is not a number, WANTED_EVENTS if it asks
        for the event mode that it was not given, ENDED_WITHIN if it ends the simulation before the end of the
        step.
    """
    reached, end, n = t, t + h, 0
    tolerance = 1e-9 * h + 4e-16 * abs(end)  # of a large time even one rounding is more than 1e-9 of a step
    while not is_bad(status) and load(answers, 0, UINT8) == 0:
        last = load(answers, _TIME, FLOAT64)
        if last != last:
            status = NO_TIME
        elif last >= end - tolerance:
            break
        elif load(answers, 8, UINT8) != 0:
            status = ENDED_WITHIN
        elif load(answers, 16, UINT8) == 0:
            break
        elif not last > reached:
            status = STOOD_STILL
        elif n == MOST_RETURNS:
            status = TOO_MANY_RETURNS
        else:
            n += 1
            reached = last
            _clear(answers)
            status = calls.do_step_3(do_step, component, reached, end - reached, answers)
    if load(answers, 0, UINT8) != 0 and not is_bad(status):
        status = WANTED_EVENTS
    asks_for_end = load(answers, 8, UINT8) != 0
    _clear(answers)
    return Answer(status, asks_for_end)


@inner
def _clear(answers: int) -> None:
    for j in range(4):
        store(answers, j, FLOAT64, 0.0)


@inner
def channel(row: Floats, rings: Floats, first: int, n: int, k: int, value: float) -> Any:
    """
    Pass a value through a connection under a scenario: delay, jitter, offset, freeze, drop.

    Jitter adds 0 to `JITTER` ticks, drawn by the generator of Park and Miller (minimal standard,
    multiplier 48271, Comm. ACM 36 (1993) 105-110) whose state is in the row.
    """
    rings[first + k % n] = value
    age = np.int64(row[DELAY])
    if row[JITTER] > 0.0:
        if row[DRAWN] != k:  # once a tick, however often an iterated group passes here
            state = (_MULTIPLIER * np.int64(row[RANDOM])) % _MODULUS
            row[RANDOM] = state
            row[DRAWN] = k
            row[MORE] = state % (np.int64(row[JITTER]) + 1)
        age += np.int64(row[MORE])
    if row[MODE] == FREEZE:
        return row[HELD]
    if row[MODE] == DROP:
        return row[FALLBACK]
    row[HELD] = rings[first + (k - age) % n] + row[OFFSET]
    return row[HELD]


@inner
def mapped(maps: Floats, first: int, n: int, value: float) -> float:
    """Value that n rows of `maps` put in the place of another; the value itself where none names it."""
    for j in range(first, first + n):
        if maps[j, 0] == value:
            return maps[j, 1]  # type: ignore[no-any-return]
    return value


@inner
def close_loop(memory: Memory, loop: int, here: int) -> LoopDecision:
    """Decide after a pass over an iterated group whether its wires agree."""
    back, first, after, maximum, passes = memory.loops[loop]
    worst, largest = -1, 1.0
    for j in range(first, after):
        source, target, c = memory.residuals[j]
        sent = memory.conversions[c, 0] * memory.values[source] + memory.conversions[c, 1]
        ratio = abs(sent - memory.values[target]) / memory.tolerances[j]
        if not (ratio <= largest):
            worst = j
            largest = ratio
    if worst < 0 or passes + 1 >= maximum:
        memory.loops[loop, 4] = 0
        return LoopDecision(here, True, worst)
    memory.loops[loop, 4] = passes + 1
    return LoopDecision(back - 1, False, -1)

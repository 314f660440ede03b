"""The operations of the stepping loop that have a rule of their own: extrapolation, channels, iteration."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from master.fmi.native import calls
from master.fmi.native.cells import load, store
from master.fmi.native.jit import inner
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

from .program import WARNING, Memory

Floats = NDArray[np.float64]

# beside the statuses of FMI, from 0 to 5
STOOD_STILL, WANTED_EVENTS, ENDED_WITHIN, MISFIT = range(101, 105)

_MULTIPLIER, _MODULUS = 48271, 2147483647


@inner
def extrapolate(rings: Floats, first: int, order: int, value: float) -> Any:
    """
    Value one step on, by the polynomial through the present and the `order` last values.

        order 1: 2 u0 - u1          order 2: 3 u0 - 3 u1 + u2
    """
    last = rings[first]
    rings[first] = value
    if order == 1:
        return 2.0 * value - last
    before = rings[first + 1]
    rings[first + 1] = last
    return 3.0 * value - 3.0 * last + before


@inner
def asks(answers: int) -> bool:
    """Whether an FMU 3.0 asks for anything after a step: see `heed`."""
    return load(answers, 0, UINT8) + load(answers, 8, UINT8) + load(answers, 16, UINT8) > 0.0


@inner
def heed(
    slave: tuple[int, int],
    function: int,
    step: tuple[float, float],
    answers: int,
    state: tuple[int, int, int],
) -> tuple[int, int]:
    """
    Heed what an FMU 3.0 asked for in the step (t, h) [s]: after an early return, step on to the end.

    `answers` is the address of four cells of 8 bytes: event mode, end of the simulation, early return, time
    reached [s]. `state` is (status, operation at which the end of the simulation was asked for or -1, this
    operation).

    Returns:
        Status and the second of `state` anew. The status is STOOD_STILL if it returned without getting on,
        WANTED_EVENTS if it asks for the event mode that it was not given, ENDED_WITHIN if it ends the
        simulation before the end of the step.
    """
    status, ended, here = state
    reached, end, tolerance = step[0], step[0] + step[1], 1e-9 * step[1]
    while status <= WARNING and load(answers, 0, UINT8) == 0 and load(answers, 3, FLOAT64) < end - tolerance:
        last = load(answers, 3, FLOAT64)
        if load(answers, 8, UINT8) != 0:
            status = ENDED_WITHIN
        elif not last > reached:
            status = STOOD_STILL
        else:
            reached = last
            _clear(answers)
            status = calls.do_step_3(function, slave[0], reached, end - reached, answers)
    if load(answers, 0, UINT8) != 0 and status <= WARNING:
        status = WANTED_EVENTS
    if load(answers, 8, UINT8) != 0:
        ended = here
    _clear(answers)
    return status, ended


@inner
def _clear(answers: int) -> None:
    for j in range(4):
        store(answers, j, FLOAT64, 0.0)


@inner
def channel(row: Floats, rings: Floats, first: int, n: int, k: int, value: float) -> Any:
    """
    Pass a value through a connection under a scenario: delay, jitter, offset, freeze, drop.

    Jitter adds 0 to `JITTER` ticks, drawn by the generator of Park and Miller (minimal standard,
    multiplier 48271, Comm. ACM 36 (1993) 105-110) whose state stands in the row.
    """
    rings[first + k % n] = value
    age = np.int64(row[DELAY])
    if row[JITTER] > 0.0:
        if row[DRAWN] != k:  # once a tick, however often an iterated group passes here
            state = (_MULTIPLIER * np.int64(row[RANDOM])) % _MODULUS
            row[RANDOM], row[DRAWN] = state, k
            row[MORE] = state % (np.int64(row[JITTER]) + 1)
        age += np.int64(row[MORE])
    if row[MODE] == FREEZE:
        return row[HELD]
    if row[MODE] == DROP:
        return row[FALLBACK]
    row[HELD] = rings[first + (k - age) % n] + row[OFFSET]
    return row[HELD]


@inner
def close_loop(memory: Memory, loop: int, here: int, ended: int) -> tuple[int, int, int]:
    """
    Decide after a pass over an iterated group whether its wires agree.

    Returns:
        Operation behind which to go on: `here` or that before the next pass; the operation at which an FMU
        asked for the end of the simulation, or -1 if that was in a pass that is taken back; row of the
        worst wire if the passes are used up, else -1.
    """
    back, first, end, most, passes = memory.loops[loop]
    worst, largest = -1, 1.0
    for j in range(first, end):
        source, target, c = memory.residuals[j]
        sent = memory.conversions[c, 0] * memory.values[source] + memory.conversions[c, 1]
        ratio = abs(sent - memory.values[target]) / memory.tolerances[j]
        if not (ratio <= largest):
            worst, largest = j, ratio
    if worst < 0:
        memory.loops[loop, 4] = 0
        return here, ended, -1
    memory.loops[loop, 4] = passes + 1
    if passes + 1 >= most:
        memory.loops[loop, 4] = 0
        return here, ended, worst
    return back - 1, -1, -1

"""The stepping loop: executes the flat program tick by tick and records. One function, compiled or not."""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from functools import lru_cache
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numba.extending import register_jitable
from numpy.typing import NDArray

from ..fmi.value_types import FLOAT64, LARGEST_SIZE, first_misfit, pack, unpack
from . import calls
from .operations import MISFIT, channel, close_loop, extrapolate, heed
from .program import CHANNEL, CHECK, COPY, EXTRAPOLATE, GET, KEEP, SAVE, SET, STEP, WARNING, Memory

DONE, FAILED, OUT_OF_LIMITS, NOT_CONVERGED, TRIGGERED, ENDED = range(6)
_COMPILED = ("stepping/loop", "stepping/operations", "stepping/calls", "stepping/program", "fmi/value_types")

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]
Bytes = NDArray[np.uint8]


class Watch(NamedTuple):
    """
    What is looked at after each tick: all arrays have one element a signal or trigger.

    `record`: places in the table of values; `limits`: their largest allowed magnitudes.
    `triggers`: [place, 1 if armed]; `thresholds`: [sign, threshold]; a trigger fires once, where
    sign * (value - threshold) > 0.
    """

    record: Integers
    limits: Floats
    triggers: Integers
    thresholds: Floats


@register_jitable
def _exchange(slave: tuple[int, int], function: int, block: tuple[int, ...], data: int) -> int:
    """Call a setter or getter; `slave` is (component, version), `block` (references, n, n values, ...)."""
    if slave[1] == 2:
        return calls.exchange(function, slave[0], block[0], block[1], data)
    return calls.exchange_3(function, slave[0], block[0], block[1], data, block[2])


@register_jitable
def _do_step(slave: tuple[int, int], function: int, t: float, h: float, answers: int) -> int:
    if slave[1] == 2:
        return calls.do_step(function, slave[0], t, h)
    return calls.do_step_3(function, slave[0], t, h, answers)


@register_jitable
def _move(
    values: Floats, rings: Floats, channels: Floats, k: int, numbers: tuple[int, int, int, int, int]
) -> None:
    """Execute KEEP, EXTRAPOLATE or CHANNEL."""
    code, a, b, c, d = numbers
    if code == KEEP:
        cell = c + k % d
        oldest = rings[cell]
        rings[cell] = values[a]
        values[b] = oldest
    elif code == EXTRAPOLATE:
        values[a] = extrapolate(rings, c, b, values[a])
    else:
        values[a] = channel(channels[b], rings, c, d, k, values[a])


@register_jitable
def _exchange_packed(
    slave: tuple[int, int], function: int, block: tuple[int, ...], values: Floats, scratch: Bytes
) -> int:
    """Set or get a block of another type than double; `block` goes on with place, type and operation."""
    n_values, place, kind = block[2], block[3], block[4]
    if block[5] == SET:
        if first_misfit(values, place, n_values, kind) >= 0:
            return MISFIT
        pack(values, place, n_values, kind, scratch)
        return _exchange(slave, function, block, scratch.ctypes.data)
    status = _exchange(slave, function, block, scratch.ctypes.data)
    unpack(values, place, n_values, kind, scratch)
    return status


@register_jitable
def _state(memory: Memory, i: int) -> int:
    """Save or restore the state of a slave."""
    a, function = memory.operations[i, 2], memory.operations[i, 3]
    if memory.operations[i, 0] == SAVE:
        return calls.state(function, memory.slaves[a, 0], memory.states.ctypes.data + 8 * a)
    return calls.state(function, memory.slaves[a, 0], memory.states[a])


@register_jitable
def _observe(values: Floats, watch: Watch, row: Floats, ended: int) -> tuple[int, int]:
    """Record one whole row; give DONE, or with its first cause OUT_OF_LIMITS, ENDED or TRIGGERED."""
    beyond = -1
    for j in range(watch.record.size - 1, -1, -1):
        value = values[watch.record[j]]
        row[j] = value
        if not (abs(value) <= watch.limits[j]):
            beyond = j
    if beyond >= 0:
        return OUT_OF_LIMITS, beyond
    if ended >= 0:
        return ENDED, ended
    for j in range(watch.triggers.shape[0]):
        value = values[watch.triggers[j, 0]]
        if watch.triggers[j, 1] and watch.thresholds[j, 0] * (value - watch.thresholds[j, 1]) > 0.0:
            watch.triggers[j, 1] = 0
            return TRIGGERED, j
    return DONE, 0


def execute(
    memory: Memory, watch: Watch, grid: tuple[float, float], ticks: tuple[int, int], rows: Floats
) -> tuple[int, int, int, int]:
    """
    Execute ticks and record one row after each.

    Args:
        memory: Operations of one tick and what they work on.
        watch: What is recorded, and what ends the execution.
        grid: t0 [s] and step size h [s]; tick k goes from t0 + k h to t0 + (k+1) h.
        ticks: First tick and the one behind the last.
        rows: Values after each tick, shape (ticks, recorded signals), written.

    Returns:
        Outcome, number of complete ticks, what it is about (FAILED, ENDED: operation, OUT_OF_LIMITS: signal,
        NOT_CONVERGED: row of `residuals`, TRIGGERED: trigger), FMI status.

    No array is passed on in the common branches: numba would count references each time.
    """
    operations, slaves, blocks = memory.operations, memory.slaves, memory.blocks
    values, conversions = memory.values, memory.conversions
    scratch, asked = np.zeros(LARGEST_SIZE * values.size, np.uint8), np.zeros(32, np.uint8)
    (t0, h), data, answers = grid, values.ctypes.data, asked.ctypes.data
    for k in range(ticks[0], ticks[1]):
        i, status, worst, ended = 0, 0, -1, -1
        while i < operations.shape[0]:
            code, every, a, b = operations[i, 0], operations[i, 1], operations[i, 2], operations[i, 3]
            c, d = operations[i, 4], operations[i, 5]
            if every > 1 and (k + 1) % every != 0:
                pass
            elif code == COPY:
                values[b] = conversions[c, 0] * values[a] + conversions[c, 1]
            elif code <= CHANNEL:
                _move(values, memory.rings, memory.channels, k, (code, a, b, c, d))
            elif code == STEP:
                slave, begin = (slaves[a, 0], slaves[a, 1]), t0 + (k + 1 - every) * h
                status = _do_step(slave, b, begin, every * h, answers)
                if asked[0] | asked[8] | asked[16]:
                    status, ended = heed(slave, b, (begin, begin + every * h), asked, (status, ended, i))
            elif code <= GET:
                slave = (slaves[a, 0], slaves[a, 1])
                block = (blocks[c, 0], blocks[c, 1], blocks[c, 4], blocks[c, 2], blocks[c, 3])
                if block[4] == FLOAT64:
                    status = _exchange(slave, b, block, data + 8 * block[3])
                else:
                    status = _exchange_packed(slave, b, (*block, code), values, scratch)
            elif code == CHECK:
                i, ended, worst = close_loop(memory, a, i, ended)
                if worst >= 0:
                    return NOT_CONVERGED, k - ticks[0], worst, 0
            else:
                status = _state(memory, i)
            if status > WARNING:
                return FAILED, k - ticks[0], i, status
            i += 1
        outcome, where = _observe(values, watch, rows[k - ticks[0]], ended)
        if outcome != DONE:
            return outcome, k - ticks[0] + 1, where, 0
    return DONE, ticks[1] - ticks[0], 0, 0


@lru_cache(maxsize=1)
def compiled() -> Callable[..., tuple[int, int, int, int]]:
    """
    Give `execute` as numba-compiled code, kept on disk between processes.

    It is kept beside this file or, where that cannot be written, in the user's cache; where neither can
    be, it is compiled for this process alone.
    """
    from numba import njit

    try:
        dispatcher: Any = njit(cache=True, error_model="numpy")(execute)
    except RuntimeError:
        dispatcher = njit(error_model="numpy")(execute)
    else:
        # numba looks at this file alone and would load old code where only a function it calls has changed
        dispatcher._cache._cache_file._source_stamp = _stamp()
    return dispatcher  # type: ignore[no-any-return]


def _stamp() -> str:
    folder = Path(__file__).parents[1]
    texts = [(folder / f"{name}.py").read_bytes() for name in _COMPILED]
    return hashlib.sha256(b"".join(texts)).hexdigest()

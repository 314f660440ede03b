"""The stepping loop: executes the flat program tick by tick and records. One function, compiled or not."""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from functools import lru_cache
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numba.extending import register_jitable
from numpy.typing import NDArray

from . import calls
from .operations import channel, close_loop, extrapolate
from .program import CHANNEL, CHECK, COPY, EXTRAPOLATE, KEEP, RESTORE, SAVE, SET, STEP, Memory
from .value_types import FLOAT64, LARGEST_SIZE, pack, unpack

DONE, FAILED, OUT_OF_LIMITS, NOT_CONVERGED, TRIGGERED = range(5)
WARNING = 1
_COMPILED = ("stepping", "operations", "calls", "program", "value_types")

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]


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
def _exchange(slave: Integers, function: int, block: Integers, data: int) -> int:
    references, n = block[0], block[1]
    if slave[1] == 2:
        return calls.exchange(function, slave[0], references, n, data)
    return calls.exchange_3(function, slave[0], references, n, data)


@register_jitable
def _do_step(slave: Integers, function: int, t: float, h: float, scratch: int) -> int:
    if slave[1] == 2:
        return calls.do_step(function, slave[0], t, h)
    return calls.do_step_3(function, slave[0], t, h, scratch)


@register_jitable
def _transfer(memory: Memory, k: int, i: int) -> None:
    """Execute an operation that moves values within the table."""
    code, _, a, b, c, d = memory.operations[i]
    values, rings = memory.values, memory.rings
    if code == COPY:
        values[b] = memory.conversions[c, 0] * values[a] + memory.conversions[c, 1]
    elif code == KEEP:
        cell = c + k % d
        oldest = rings[cell]
        rings[cell] = values[a]
        values[b] = oldest
    elif code == EXTRAPOLATE:
        values[a] = extrapolate(rings, c, b, values[a])
    else:
        values[a] = channel(memory.channels[b], rings, c, d, k, values[a])


@register_jitable
def _call(memory: Memory, i: int, start: float, h: float, scratch: NDArray[np.uint8]) -> int:
    """Execute an operation that calls a slave; give its FMI status."""
    code, _, a, b, c, _ = memory.operations[i]
    slave, values = memory.slaves[a], memory.values
    data = scratch.ctypes.data
    if code == STEP:
        return _do_step(slave, b, start, h, data)
    if code == SAVE:
        return calls.state(b, slave[0], memory.states.ctypes.data + 8 * a)
    if code == RESTORE:
        return calls.state(b, slave[0], memory.states[a])
    block = memory.blocks[c]
    if block[3] == FLOAT64:
        return _exchange(slave, b, block, values.ctypes.data + 8 * block[2])
    if code == SET:
        pack(values, block[2], block[1], block[3], scratch)
        return _exchange(slave, b, block, data)
    status = _exchange(slave, b, block, data)
    unpack(values, block[2], block[1], block[3], scratch)
    return status


@register_jitable
def _observe(values: Floats, watch: Watch, row: Floats) -> tuple[int, int]:
    """Record one row; give DONE, or OUT_OF_LIMITS or TRIGGERED with the signal or trigger."""
    for j in range(watch.record.size):
        value = values[watch.record[j]]
        row[j] = value
        if not (abs(value) <= watch.limits[j]):
            return OUT_OF_LIMITS, j
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
        Outcome, number of complete ticks, what it is about (FAILED: operation, OUT_OF_LIMITS: signal,
        NOT_CONVERGED: row of `residuals`, TRIGGERED: trigger), FMI status.
    """
    operations = memory.operations
    t0, h = grid
    first, end = ticks
    scratch = np.zeros(LARGEST_SIZE * max(4, memory.values.size), dtype=np.uint8)
    for k in range(first, end):
        i = 0
        while i < operations.shape[0]:
            code, every = operations[i, 0], operations[i, 1]
            if (k + 1) % every != 0:
                pass
            elif code <= CHANNEL:
                _transfer(memory, k, i)
            elif code == CHECK:
                back, worst = close_loop(memory, operations[i, 2])
                if worst >= 0:
                    return NOT_CONVERGED, k - first, worst, 0
                if back >= 0:
                    i = back - 1
            else:
                status = _call(memory, i, t0 + (k + 1 - every) * h, every * h, scratch)
                if status > WARNING:
                    return FAILED, k - first, i, status
            i += 1
        outcome, where = _observe(memory.values, watch, rows[k - first])
        if outcome != DONE:
            return outcome, k - first + 1, where, 0
    return DONE, end - first, 0, 0


@lru_cache(maxsize=1)
def compiled() -> Callable[..., tuple[int, int, int, int]]:
    """Give `execute` as numba-compiled code, kept on disk between processes."""
    from numba import njit

    dispatcher = njit(cache=True)(execute)
    # numba looks at this file alone and would load old code where only a function it calls has changed
    dispatcher._cache._cache_file._source_stamp = _stamp()  # type: ignore[attr-defined]
    return dispatcher


def _stamp() -> str:
    folder = Path(__file__).parent
    texts = [(folder / f"{name}.py").read_bytes() for name in _COMPILED]
    return hashlib.sha256(b"".join(texts)).hexdigest()

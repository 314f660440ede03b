"""The stepping loop: executes the flat program tick by tick and records. One function, compiled or not."""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from functools import lru_cache
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from master.fmi.native import calls
from master.fmi.native.cells import LARGEST_SIZE, row_at, store, whole
from master.fmi.native.jit import inner
from master.fmi.value_types import FLOAT64
from master.process.position import SLAVE, TICK

from .fmu_step import ANSWERS, copy, record, turn
from .operations import channel, close_loop, extrapolate
from .program import (
    CHANNEL,
    CHECK,
    COPY,
    COPY_WIDTH,
    EXTRAPOLATE,
    KEEP,
    OPERATION_WIDTH,
    SAVE,
    SLAVE_WIDTH,
    STEP,
    WARNING,
    Memory,
)

DONE, FAILED, OUT_OF_LIMITS, NOT_CONVERGED, TRIGGERED, ENDED = range(6)
_COMPILED = (
    "stepping/machine/interpreter",
    "stepping/machine/fmu_step",
    "stepping/machine/operations",
    "stepping/machine/program",
    "fmi/native/calls",
    "fmi/native/cells",
    "fmi/native/float_mode",
    "fmi/native/jit",
    "fmi/value_types",
    "process/position",
)

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


@inner
def _move(values: Floats, rings: Floats, channels: Floats, k: int, operation: tuple[int, ...]) -> None:
    """Execute KEEP, EXTRAPOLATE or CHANNEL in tick k."""
    code, a, b, c, d = operation
    if code == KEEP:
        cell = c + k % d
        oldest = rings[cell]
        rings[cell] = values[a]
        values[b] = oldest
    elif code == EXTRAPOLATE:
        values[a] = extrapolate(rings, c, b, values[a])
    else:
        values[a] = channel(channels[b], rings, c, d, k, values[a])


@inner
def _iterate(memory: Memory, i: int, ended: int) -> tuple[int, int, int, int]:
    """Execute SAVE, RESTORE or CHECK; give the status and the results of `close_loop`."""
    code, a, function = memory.operations[i, 0], memory.operations[i, 2], memory.operations[i, 3]
    if code == CHECK:
        i, ended, worst = close_loop(memory, a, i, ended)
        return 0, i, ended, worst
    argument = memory.states.ctypes.data + 8 * a if code == SAVE else memory.states[a]
    return calls.state(function, memory.slaves[a, 0], argument), i, ended, -1


@inner
def _triggered(values: Floats, watch: Watch) -> int:
    """Give the first trigger that fires and disarm it, or -1."""
    for j in range(watch.triggers.shape[0]):
        value = values[watch.triggers[j, 0]]
        if watch.triggers[j, 1] and watch.thresholds[j, 0] * (value - watch.thresholds[j, 1]) > 0.0:
            watch.triggers[j, 1] = 0
            return j
    return -1


@inner
def _n_first(record: Integers) -> int:
    """Count the signals recorded first that are the first places in order: these are copied as one."""
    n = 0
    while n < record.size and record[n] == n:
        n += 1
    return n


@inner
def _first_beyond(values: Floats, watch: Watch) -> int:
    j = 0
    while abs(values[watch.record[j]]) <= watch.limits[j]:
        j += 1
    return j


@inner
def _outcome(values: Floats, watch: Watch, n_beyond: int, ended: int) -> tuple[int, int]:
    """DONE, or with its first cause OUT_OF_LIMITS, ENDED or TRIGGERED."""
    if n_beyond > 0:
        return OUT_OF_LIMITS, _first_beyond(values, watch)
    if ended >= 0:
        return ENDED, ended
    trigger = _triggered(values, watch)
    return (TRIGGERED, trigger) if trigger >= 0 else (DONE, 0)


def execute(
    memory: Memory,
    watch: Watch,
    grid: tuple[float, float],
    ticks: tuple[int, int],
    rows: Floats,
    general: bool | None = True,
) -> tuple[int, int, int, int]:
    """
    Execute ticks and record one row after each.

    Args:
        memory: Operations of one tick and what they work on.
        watch: What is recorded, and what ends the execution.
        grid: t0 [s] and step size h [s]; tick k goes from t0 + k h to t0 + (k+1) h.
        ticks: First tick and the one behind the last.
        rows: Values after each tick, shape (ticks, recorded signals), written.
        general: None for a program that `is_plain`: numba leaves out what it does not need.

    Returns:
        Outcome, number of complete ticks, what it is about (FAILED, ENDED: operation, OUT_OF_LIMITS: signal,
        NOT_CONVERGED: row of `residuals`, TRIGGERED: trigger), FMI status.
    """
    values, n_operations, operations = (
        memory.values,
        memory.operations.shape[0],
        memory.operations.ctypes.data,
    )
    slaves, blocks, data = memory.slaves.ctypes.data, memory.blocks.ctypes.data, values.ctypes.data
    copies, conversions = memory.copies.ctypes.data, memory.conversions.ctypes.data
    scratch = np.zeros(ANSWERS + LARGEST_SIZE * values.size, np.uint8)
    observed, has_triggers = (watch.record.ctypes.data, watch.limits.ctypes.data), watch.triggers.shape[0] > 0
    n_recorded, written = (_n_first(watch.record), watch.record.size), rows.ctypes.data
    (t0, h), room, position = grid, (data, scratch.ctypes.data), memory.position.ctypes.data
    for k in range(ticks[0], ticks[1]):
        store(position, TICK, FLOAT64, float(k))
        i, status, worst, ended, row = 0, 0, -1, -1, k - ticks[0]
        while i < n_operations:
            at = row_at(operations, OPERATION_WIDTH, i)
            code, every, a, b = whole(at, 0), whole(at, 1), whole(at, 2), whole(at, 3)
            if every > 1 and (k + 1) % every != 0:
                pass
            elif code == COPY:
                copy(row_at(copies, COPY_WIDTH, a), row_at(copies, COPY_WIDTH, b), conversions, data)
            elif code == STEP:
                step = (t0 + (k + 1 - every) * h, every * h)
                store(position, SLAVE, FLOAT64, float(a))
                slave = row_at(slaves, SLAVE_WIDTH, a)
                status, ended = turn(slave, blocks, step, room, (ended, i), general, position)
            elif general is None:
                pass
            elif code <= CHANNEL:
                operation = (code, a, b, whole(at, 4), whole(at, 5))
                _move(values, memory.rings, memory.channels, k, operation)
            else:
                status, i, ended, worst = _iterate(memory, i, ended)
            if worst >= 0 or status > WARNING:
                return (NOT_CONVERGED, row, worst, 0) if worst >= 0 else (FAILED, row, i, status)
            i += 1
        n_beyond = record(row_at(written, n_recorded[1], row), data, observed, n_recorded)
        if n_beyond > 0 or ended >= 0 or has_triggers:
            outcome, where = _outcome(values, watch, n_beyond, ended)
            if outcome != DONE:
                return outcome, row + 1, where, 0
    return DONE, ticks[1] - ticks[0], 0, 0


def is_plain(memory: Memory) -> bool:
    """Whether a program holds only copies and steps of FMUs 2.0, as most do."""
    return bool((memory.operations[:, 0] <= STEP).all() and (memory.slaves[:, 1] == 2).all())


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

    def run(memory: Memory, *run: Any) -> tuple[int, int, int, int]:
        return dispatcher(memory, *run, None if is_plain(memory) else True)  # type: ignore[no-any-return]

    return run


def _stamp() -> str:
    folder = Path(__file__).parents[2]
    texts = [(folder / f"{name}.py").read_bytes() for name in _COMPILED]
    return hashlib.sha256(b"".join(texts)).hexdigest()

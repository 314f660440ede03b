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

from ..fmi.cells import LARGEST_SIZE, pack, unpack
from ..fmi.value_types import FLOAT64
from . import calls
from .operations import MISFIT, asks, channel, close_loop, extrapolate, heed
from .program import CHANNEL, CHECK, COPY, EXTRAPOLATE, KEEP, SAVE, STEP, WARNING, Memory

DONE, FAILED, OUT_OF_LIMITS, NOT_CONVERGED, TRIGGERED, ENDED = range(6)
_COMPILED = (
    *("stepping/loop", "stepping/operations", "stepping/calls", "stepping/program"),
    *("fmi/cells", "fmi/value_types"),
)
_ANSWERS = 32  # bytes, see `operations.heed`

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
def _exchange(slave: tuple[int, int], block: tuple[int, int, int, int], data: int) -> int:
    """Call a setter or getter: `slave` is (component, version), `block` (function, references, n, values)."""
    if slave[1] == 2:
        return calls.exchange(block[0], slave[0], block[1], block[2], data)
    return calls.exchange_3(block[0], slave[0], block[1], block[2], data, block[3])


@register_jitable
def _set(slave: tuple[int, int], block: tuple[int, int, int, int], kind: int, data: int, typed: int) -> int:
    """Set a block whose values stand as doubles at `data`; other types pass through memory at `typed`."""
    if kind == FLOAT64:
        return _exchange(slave, block, data)
    if not pack(data, block[3], kind, typed):
        return MISFIT
    return _exchange(slave, block, typed)


@register_jitable
def _get(slave: tuple[int, int], block: tuple[int, int, int, int], kind: int, data: int, typed: int) -> int:
    """Get a block, the other way."""
    if kind == FLOAT64:
        return _exchange(slave, block, data)
    status = _exchange(slave, block, typed)
    unpack(data, block[3], kind, typed)
    return status


@register_jitable
def _do_step(
    slave: tuple[int, int], function: int, step: tuple[float, float], answers: int, state: tuple[int, int]
) -> tuple[int, int]:
    """
    Make the step (t, h) [s]; `state` is (operation at which the end was asked for or -1, this operation).

    Returns:
        Status and the first of `state` anew; see `heed`.
    """
    if slave[1] == 2:
        return calls.do_step(function, slave[0], step[0], step[1]), state[0]
    status = calls.do_step_3(function, slave[0], step[0], step[1], answers)
    if asks(answers):
        return heed(slave, function, step, answers, (status, state[0], state[1]))
    return status, state[0]


@register_jitable
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


@register_jitable
def _iterate(memory: Memory, i: int, ended: int) -> tuple[int, int, int, int]:
    """Execute SAVE, RESTORE or CHECK; give the status and the results of `close_loop`."""
    code, a, function = memory.operations[i, 0], memory.operations[i, 2], memory.operations[i, 3]
    if code == CHECK:
        i, ended, worst = close_loop(memory, a, i, ended)
        return 0, i, ended, worst
    argument = memory.states.ctypes.data + 8 * a if code == SAVE else memory.states[a]
    return calls.state(function, memory.slaves[a, 0], argument), i, ended, -1


@register_jitable
def _triggered(values: Floats, watch: Watch) -> int:
    """Give the first trigger that fires and disarm it, or -1."""
    for j in range(watch.triggers.shape[0]):
        value = values[watch.triggers[j, 0]]
        if watch.triggers[j, 1] and watch.thresholds[j, 0] * (value - watch.thresholds[j, 1]) > 0.0:
            watch.triggers[j, 1] = 0
            return j
    return -1


@register_jitable
def _n_first(record: Integers) -> int:
    """Count the signals recorded first that are the first places in order: these are copied as one."""
    n = 0
    while n < record.size and record[n] == n:
        n += 1
    return n


@register_jitable
def _first_beyond(values: Floats, watch: Watch) -> int:
    j = 0
    while abs(values[watch.record[j]]) <= watch.limits[j]:
        j += 1
    return j


# The next two are inlined by numba, and `execute` hands no array on in its common branches: a call that does
# counts references each time.
@register_jitable(inline="always")
def _copy(values: Floats, copies: Integers, conversions: Floats, rows: tuple[int, int]) -> None:
    """Execute rows of `copies`."""
    for j in range(rows[0], rows[1]):
        factor, offset = conversions[copies[j, 2], 0], conversions[copies[j, 2], 1]
        values[copies[j, 1]] = factor * values[copies[j, 0]] + offset


@register_jitable(inline="always")
def _observe(
    values: Floats, watch: Watch, n_first: int, table: tuple[Floats, int], ended: int
) -> tuple[int, int]:
    """
    Record one row of a table, its first `n_first` signals from as many first values.

    Returns:
        DONE, or with its first cause OUT_OF_LIMITS, ENDED or TRIGGERED.
    """
    rows, row = table
    n_beyond, trigger = 0, -1
    for j in range(n_first):
        rows[row, j] = values[j]
        n_beyond += not abs(values[j]) <= watch.limits[j]
    for j in range(n_first, watch.record.size):
        rows[row, j] = values[watch.record[j]]
        n_beyond += not abs(values[watch.record[j]]) <= watch.limits[j]
    if watch.triggers.shape[0] > 0 and n_beyond == 0 and ended < 0:
        trigger = _triggered(values, watch)
    if n_beyond > 0:
        return OUT_OF_LIMITS, _first_beyond(values, watch)
    if ended >= 0:
        return ENDED, ended
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
    operations, slaves, blocks = memory.operations, memory.slaves, memory.blocks
    values, copies, conversions = memory.values, memory.copies, memory.conversions
    scratch, n_first = np.zeros(_ANSWERS + LARGEST_SIZE * values.size, np.uint8), _n_first(watch.record)
    (t0, h), data, answers = grid, values.ctypes.data, scratch.ctypes.data
    for k in range(ticks[0], ticks[1]):
        i, status, worst, ended, row = 0, 0, -1, -1, k - ticks[0]
        while i < operations.shape[0]:
            code, every, a, b = operations[i, 0], operations[i, 1], operations[i, 2], operations[i, 3]
            if every > 1 and (k + 1) % every != 0:
                pass
            elif code == COPY:
                _copy(values, copies, conversions, (a, b))
            elif code == STEP:
                slave, step = (slaves[a, 0], slaves[a, 1]), (t0 + (k + 1 - every) * h, every * h)
                for j in range(slaves[a, 3], slaves[a, 4]):
                    if status <= WARNING:
                        block = (blocks[j, 0], blocks[j, 1], blocks[j, 2], blocks[j, 3])
                        status = _set(slave, block, blocks[j, 4], data + 8 * blocks[j, 5], answers + _ANSWERS)
                if general is None:
                    status = calls.do_step(slaves[a, 2], slave[0], *step) if status <= WARNING else status
                elif status <= WARNING:
                    status, ended = _do_step(slave, slaves[a, 2], step, answers, (ended, i))
                for j in range(slaves[a, 5], slaves[a, 6]):
                    if status <= WARNING:
                        block = (blocks[j, 0], blocks[j, 1], blocks[j, 2], blocks[j, 3])
                        status = _get(slave, block, blocks[j, 4], data + 8 * blocks[j, 5], answers + _ANSWERS)
            elif general is None:
                pass
            elif code <= CHANNEL:
                operation = (code, a, b, operations[i, 4], operations[i, 5])
                _move(values, memory.rings, memory.channels, k, operation)
            else:
                status, i, ended, worst = _iterate(memory, i, ended)
            if worst >= 0 or status > WARNING:
                return (NOT_CONVERGED, row, worst, 0) if worst >= 0 else (FAILED, row, i, status)
            i += 1
        outcome, where = _observe(values, watch, n_first, (rows, row), ended)
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
    folder = Path(__file__).parents[1]
    texts = [(folder / f"{name}.py").read_bytes() for name in _COMPILED]
    return hashlib.sha256(b"".join(texts)).hexdigest()

"""The stepping loop: executes the flat program tick by tick and records. One function, compiled or not."""

from __future__ import annotations

from enum import IntEnum
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from master.fmi.native import calls
from master.fmi.native.cells import integer_at, row_at, store
from master.fmi.native.jit import inner
from master.fmi.value_types import FLOAT64
from master.process import position as cell

from .fmu_step import RESTORED, SAVED, STEPPED, copy, feed, record, step_fmu
from .operations import ENDED_WITHIN, NO_STATE, channel, close_loop, extrapolate, is_bad, mapped
from .pace import STOPS, is_overrun, wait_for
from .program import (
    CHECK,
    COLLECT,
    COPY,
    COPY_WIDTH,
    EXTRAPOLATE,
    FEED,
    FEED_WIDTH,
    KEEP,
    MAP,
    OPERATION_WIDTH,
    SAVE,
    SLAVE_WIDTH,
    STEP,
    Floats,
    Integers,
    Memory,
)

LARGEST = float(np.finfo(np.float64).max)  # the limit of a signal that has only to be finite

# As numbers of their own, for compiled code.
PHASE = cell.PHASE
SLAVE = cell.SLAVE
TICK = cell.TICK
SAVING = float(cell.SAVING)
RESTORING = float(cell.RESTORING)


class Stop(IntEnum):
    """Why an execution stopped."""

    DONE = 0
    FAILED = 1
    OUT_OF_LIMITS = 2
    NOT_CONVERGED = 3
    TRIGGERED = 4
    ASKED_FOR_END = 5
    LATE = 6


DONE, FAILED, OUT_OF_LIMITS, NOT_CONVERGED, TRIGGERED, ASKED_FOR_END, LATE = map(int, Stop)


class Execution(NamedTuple):
    """
    How an execution of ticks ended.

    `ticks`: number of complete ones. `where`: the operation (FAILED, ASKED_FOR_END), recorded signal
    (OUT_OF_LIMITS), row of `residuals` (NOT_CONVERGED) or trigger (TRIGGERED). `status` and `call` of an FMU:
    see `Deviation` and `Call`.
    """

    stop: int
    ticks: int
    where: int
    status: int
    call: int


class LimitMonitor(NamedTuple):
    """
    What is looked at after each tick: all arrays have one element a recorded signal or trigger.

    `record`: places in the table of values; `limits`: their largest allowed magnitudes; `used`: 0 for a
    signal that nobody uses, which does not end the execution; `first_beyond`: for such a one the first tick
    after which it was beyond its limit or not finite, -1 before. `triggers`: [place, 1 if armed];
    `thresholds`: [sign, threshold]; a trigger fires once, where sign * (value - threshold) > 0.
    """

    record: Integers
    limits: Floats
    used: Integers
    first_beyond: Integers
    triggers: Integers
    thresholds: Floats


def finite_only(places: NDArray[np.int64]) -> LimitMonitor:
    """Record signals that have only to be finite."""
    n = len(places)
    return LimitMonitor(
        record=places,
        limits=np.full(n, LARGEST),
        used=np.ones(n, dtype=np.int64),
        first_beyond=np.full(n, -1, dtype=np.int64),
        triggers=np.zeros((0, 2), dtype=np.int64),
        thresholds=np.zeros((0, 2)),
    )


@inner
def _move(memory: Memory, k: int, code: int, a: int, b: int, c: int, d: int) -> None:
    """Execute KEEP, COLLECT, EXTRAPOLATE, CHANNEL or MAP in tick k."""
    values, rings = memory.values, memory.rings
    if code == KEEP:
        cell = c + k % d
        oldest = rings[cell]
        rings[cell] = values[a]
        values[b] = oldest
    elif code == COLLECT:
        values[b + k % c] = values[a]
    elif code == EXTRAPOLATE:
        values[a] = extrapolate(rings, c, b, values[a])
    elif code == MAP:
        values[b] = mapped(memory.maps, c, d, values[a])
    else:
        values[a] = channel(memory.channels[b], rings, c, d, k, values[a])


@inner
def _save_or_restore(memory: Memory, code: int, slave: int, function: int, position: int) -> int:
    """Execute SAVE or RESTORE; give the status."""
    store(position, SLAVE, FLOAT64, float(slave))
    store(position, PHASE, FLOAT64, SAVING if code == SAVE else RESTORING)
    argument = memory.states.ctypes.data + 8 * slave if code == SAVE else memory.states[slave]
    status = calls.state(function, memory.slaves[slave, 0], argument)
    if code == SAVE and not is_bad(status) and memory.states[slave] == 0:
        return NO_STATE
    return status


@inner
def _triggered(values: Floats, monitor: LimitMonitor) -> int:
    """Give the first trigger that fires and disarm it, or -1."""
    for j in range(monitor.triggers.shape[0]):
        value = values[monitor.triggers[j, 0]]
        if monitor.triggers[j, 1] and monitor.thresholds[j, 0] * (value - monitor.thresholds[j, 1]) > 0.0:
            monitor.triggers[j, 1] = 0
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
def _first_beyond(values: Floats, monitor: LimitMonitor, k: int) -> int:
    """Give the first signal that is used and beyond its limit, or -1; note the others."""
    for j in range(monitor.record.size):
        if not abs(values[monitor.record[j]]) <= monitor.limits[j]:
            if monitor.used[j]:
                return j
            if monitor.first_beyond[j] < 0:
                monitor.first_beyond[j] = k
    return -1


@inner
def _after_tick(
    memory: Memory, monitor: LimitMonitor, k: int, row: int, n_beyond: int, ended: int
) -> Execution:
    """DONE, or with its first cause OUT_OF_LIMITS, ASKED_FOR_END or TRIGGERED, after tick k of row `row`."""
    if n_beyond > 0:
        beyond = _first_beyond(memory.values, monitor, k)
        if beyond >= 0:
            return Execution(OUT_OF_LIMITS, row + 1, beyond, 0, 0)
    if ended >= 0:
        return Execution(ASKED_FOR_END, row + 1, ended, 0, 0)
    trigger = _triggered(memory.values, monitor)
    if trigger >= 0:
        return Execution(TRIGGERED, row + 1, trigger, 0, 0)
    return Execution(DONE, row + 1, 0, 0, 0)


@inner
def execute(  # noqa: C901, PLR0913 - the one dispatch over all operations, in one function for the compiler
    memory: Memory,
    monitor: LimitMonitor,
    t0: float,
    h: float,
    begin: int,
    end: int,
    rows: Floats,
    general: bool | None = True,
    pace: int | None = None,
) -> Execution:
    """
    Execute ticks and record one row after each.

    Args:
        memory: Operations of one tick and what they work on.
        monitor: What is recorded, and what ends the execution.
        t0: Start of tick 0 [s].
        h: Length of a tick [s]; tick k goes from t0 + k h to t0 + (k+1) h.
        begin: First tick.
        end: The one after the last.
        rows: Values after each tick, shape (ticks, recorded signals), written.
        general: None for a program that `is_plain`: numba leaves out what it does not need.
        pace: Address of the cells of `pace`, None if ticks follow each other at once.
    """
    operations = memory.operations.ctypes.data
    n_operations = memory.operations.shape[0]
    slaves = memory.slaves.ctypes.data
    blocks = memory.blocks.ctypes.data
    copies = memory.copies.ctypes.data
    conversions = memory.conversions.ctypes.data
    feeds = memory.feeds.ctypes.data
    measured = memory.measured.ctypes.data
    n_columns = memory.measured.shape[1]
    values = memory.values.ctypes.data
    scratch = memory.scratch.ctypes.data
    places = monitor.record.ctypes.data
    limits = monitor.limits.ctypes.data
    n_first = _n_first(monitor.record)
    n_recorded = monitor.record.size
    written = rows.ctypes.data
    has_triggers = monitor.triggers.shape[0] > 0
    position = memory.position.ctypes.data
    for k in range(begin, end):
        if pace is not None:
            wait_for(pace, k)
        store(position, TICK, FLOAT64, float(k))
        i, ended, row = 0, -1, k - begin
        while i < n_operations:
            at = row_at(operations, OPERATION_WIDTH, i)
            code, every, a, b = integer_at(at, 0), integer_at(at, 1), integer_at(at, 2), integer_at(at, 3)
            if every > 1 and (k + 1) % every != 0:
                pass
            elif code == COPY:
                copy(row_at(copies, COPY_WIDTH, a), row_at(copies, COPY_WIDTH, b), conversions, values)
            elif code == STEP:
                length = integer_at(at, 4)
                t = t0 + (k + 1 - b) * h
                slave = row_at(slaves, SLAVE_WIDTH, a)
                store(position, SLAVE, FLOAT64, float(a))
                step = step_fmu(slave, blocks, t, length * h, values, scratch, general, position)
                if is_bad(step.status):
                    return Execution(FAILED, row, i, step.status, step.call)
                if general is not None and step.asks_for_end:
                    if b != length:  # more steps follow in this tick, but not of an FMU that has ended
                        return Execution(FAILED, row, i, ENDED_WITHIN, STEPPED)
                    ended = i
            elif code == FEED:
                tick = row_at(measured, n_columns, k + 1)
                feed(row_at(feeds, FEED_WIDTH, a), row_at(feeds, FEED_WIDTH, b), tick, values)
            elif general is None:
                pass
            elif code <= MAP:
                _move(memory, k, code, a, b, integer_at(at, 4), integer_at(at, 5))
            elif code == CHECK:
                decision = close_loop(memory, a, i)
                if decision.worst >= 0:
                    return Execution(NOT_CONVERGED, row, decision.worst, 0, 0)
                i = decision.operation
                if not decision.closed:
                    ended = -1  # what was asked for in a pass is taken back with it
            else:
                status = _save_or_restore(memory, code, a, b, position)
                if is_bad(status):
                    return Execution(FAILED, row, i, status, SAVED if code == SAVE else RESTORED)
            i += 1
        n_beyond = record(row_at(written, n_recorded, row), values, places, limits, n_first, n_recorded)
        if n_beyond > 0 or ended >= 0 or has_triggers:
            after = _after_tick(memory, monitor, k, row, n_beyond, ended)
            if after.stop != DONE:
                return after
        if pace is not None and is_overrun(pace, k) and integer_at(pace, STOPS) != 0:
            return Execution(LATE, row + 1, 0, 0, 0)
    return Execution(DONE, end - begin, 0, 0, 0)


def is_plain(memory: Memory) -> bool:
    """Whether a program holds only copies and steps of FMUs 2.0, as most do."""
    return bool((memory.operations[:, 0] <= STEP).all() and (memory.slaves[:, 1] == 2).all())

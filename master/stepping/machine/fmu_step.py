"""
What a program does most: copies, steps of FMUs (set inputs, step, get outputs), and a row of results a tick.

Addresses and numbers alone pass here, and tables are read without bounds: an array handed on would have its
references counted, and an index into it would be looked at for counting from the end.
"""

from __future__ import annotations

from enum import IntEnum
from typing import NamedTuple

from master.fmi.native import calls
from master.fmi.native.cells import copy_cells, integer_at, load, pack, row_at, store, unpack
from master.fmi.native.float_mode import restore_float_mode
from master.fmi.native.jit import inlined
from master.fmi.value_types import FLOAT64
from master.process import position as cell

from .operations import MISFIT, Answer, asks, handle_step_flags, is_bad
from .program import ANSWER_CELLS, BLOCK_WIDTH, CONVERSION_WIDTH, COPY_WIDTH, FEED_WIDTH

# As numbers of their own, for compiled code.
PHASE = cell.PHASE
SLAVE = cell.SLAVE
TICK = cell.TICK
FLOAT_MODE = cell.FLOAT_MODE
FLOAT_TICK = cell.FLOAT_TICK
SETTING = float(cell.SETTING)
MAKING_A_STEP = float(cell.MAKING_A_STEP)
GETTING = float(cell.GETTING)

ANSWERS = 8 * ANSWER_CELLS  # bytes, see `handle_step_flags`


class Call(IntEnum):
    """Which function of an FMU answered."""

    SET = 0
    STEP = 1
    GET = 2
    SAVE = 3
    RESTORE = 4


SET, STEPPED, GET, SAVED, RESTORED = map(int, Call)


class FmuStep(NamedTuple):
    """How the step of an FMU ended: the last status and the call that it is of."""

    status: int
    call: int
    asks_for_end: bool


@inlined
def copy(row: int, after: int, conversions: int, values: int) -> None:
    """Execute the rows of `copies` from an address to before another one; all arguments are addresses."""
    while row < after:
        conversion = row_at(conversions, CONVERSION_WIDTH, integer_at(row, 2))
        factor = load(conversion, 0, FLOAT64)
        offset = load(conversion, 1, FLOAT64)
        value = load(values, integer_at(row, 0), FLOAT64)
        store(values, integer_at(row, 1), FLOAT64, factor * value + offset)
        row = row_at(row, COPY_WIDTH, 1)


@inlined
def feed(row: int, after: int, measured: int, values: int) -> None:
    """Execute the rows of `feeds` from an address to before another one; `measured` is the row's address."""
    while row < after:
        store(values, integer_at(row, 0), FLOAT64, load(measured, integer_at(row, 1), FLOAT64))
        row = row_at(row, FEED_WIDTH, 1)


@inlined
def record(row: int, values: int, places: int, limits: int, n_first: int, n: int) -> int:
    """
    Record one row of results.

    Args:
        row: Address of the row.
        values: Address of the table of values.
        places: Address of the places of the signals in it.
        limits: Address of their largest allowed magnitudes.
        n_first: Number of signals that are the first places in order, which are copied as one.
        n: Number of signals.

    Returns:
        Number of values beyond their limits or not finite.
    """
    n_beyond = 0
    copy_cells(row, values, n_first)
    for j in range(n_first):  # reads only: a loop that vectors run through
        n_beyond += not abs(load(values, j, FLOAT64)) <= load(limits, j, FLOAT64)
    for j in range(n_first, n):
        value = load(values, integer_at(places, j), FLOAT64)
        store(row, j, FLOAT64, value)
        n_beyond += not abs(value) <= load(limits, j, FLOAT64)
    return n_beyond


@inlined
def step_fmu(
    row: int, blocks: int, t: float, h: float, values: int, scratch: int, general: bool | None, position: int
) -> FmuStep:
    """
    Set the inputs of an FMU, step it, and get its outputs; up to the first call that fails.

    Whatever an FMU of others does to the floating-point mode is undone.

    Args:
        row: Address of its row in `slaves`.
        blocks: Address of the table `blocks`.
        t: Start of the step [s].
        h: Its length [s].
        values: Address of the table of values.
        scratch: Address of `ANSWERS` bytes, followed by memory for a block of any type.
        general: None if all FMUs are of FMI 2.0.
        position: Address of the cells that say where the run is.
    """
    step = _called(row, blocks, t, h, values, scratch, general, position)
    may_change_mode = integer_at(row, 7) != 0
    if may_change_mode and restore_float_mode() != 0 and load(position, FLOAT_MODE, FLOAT64) == 0.0:
        store(position, FLOAT_MODE, FLOAT64, load(position, SLAVE, FLOAT64) + 1.0)
        store(position, FLOAT_TICK, FLOAT64, load(position, TICK, FLOAT64))
    return step


@inlined
def _called(
    row: int, blocks: int, t: float, h: float, values: int, scratch: int, general: bool | None, position: int
) -> FmuStep:
    """Make the calls of `step_fmu`."""
    component = integer_at(row, 0)
    version = 2 if general is None else integer_at(row, 1)
    typed = scratch + ANSWERS
    store(position, PHASE, FLOAT64, SETTING)
    for j in range(integer_at(row, 3), integer_at(row, 4)):
        status = _set(component, version, row_at(blocks, BLOCK_WIDTH, j), values, typed)
        if is_bad(status):
            return FmuStep(status, SET, False)
    store(position, PHASE, FLOAT64, MAKING_A_STEP)
    if general is None:
        answer = Answer(calls.do_step(integer_at(row, 2), component, t, h), False)
    else:
        answer = _do_step(component, version, integer_at(row, 2), t, h, scratch)
    if is_bad(answer.status):
        return FmuStep(answer.status, STEPPED, answer.asks_for_end)
    store(position, PHASE, FLOAT64, GETTING)
    for j in range(integer_at(row, 5), integer_at(row, 6)):
        status = _get(component, version, row_at(blocks, BLOCK_WIDTH, j), values, typed)
        if is_bad(status):
            return FmuStep(status, GET, answer.asks_for_end)
    return FmuStep(0, STEPPED, answer.asks_for_end)


@inlined
def _exchange(component: int, version: int, block: int, data: int) -> int:
    """Call a setter or getter; `block` is the address of its row."""
    function, references, n = integer_at(block, 0), integer_at(block, 1), integer_at(block, 2)
    if version == 2:
        return calls.exchange(function, component, references, n, data)
    return calls.exchange_3(function, component, references, n, data, integer_at(block, 3))


@inlined
def _set(component: int, version: int, block: int, values: int, typed: int) -> int:
    """Set a block from the doubles of the table at `values`; other types pass through memory at `typed`."""
    kind, data = integer_at(block, 4), row_at(values, 1, integer_at(block, 5))
    if kind == FLOAT64:
        return _exchange(component, version, block, data)
    if not pack(data, integer_at(block, 3), kind, typed):
        return MISFIT
    return _exchange(component, version, block, typed)


@inlined
def _get(component: int, version: int, block: int, values: int, typed: int) -> int:
    """Get a block, the other way; after a failure the table keeps what it held."""
    kind, data = integer_at(block, 4), row_at(values, 1, integer_at(block, 5))
    if kind == FLOAT64:
        return _exchange(component, version, block, data)
    status = _exchange(component, version, block, typed)
    if not is_bad(status):
        unpack(data, integer_at(block, 3), kind, typed)
    return status


@inlined
def _do_step(component: int, version: int, function: int, t: float, h: float, answers: int) -> Answer:
    """Make the step with an FMU of either version."""
    if version == 2:
        return Answer(calls.do_step(function, component, t, h), False)
    status = calls.do_step_3(function, component, t, h, answers)
    if asks(answers):
        return handle_step_flags(component, function, t, h, answers, status)
    return Answer(status, False)

"""
What a program does most: copies, turns of FMUs (set inputs, step, get outputs), and a row of results a tick.

Addresses and numbers alone pass here, and tables are read without bounds: an array handed on would have its
references counted, and an index into it would be looked at for counting from the end.
"""

from __future__ import annotations

from master.fmi.native import calls
from master.fmi.native.cells import copy_cells, load, pack, row_at, store, unpack, whole
from master.fmi.native.float_mode import restore_float_mode
from master.fmi.native.jit import inlined
from master.fmi.value_types import FLOAT64
from master.process import position as cell

from .operations import MISFIT, asks, heed
from .program import BLOCK_WIDTH, COPY_WIDTH, WARNING

PHASE = cell.PHASE
SLAVE = cell.SLAVE
TICK = cell.TICK
FLOAT_MODE = cell.FLOAT_MODE
FLOAT_TICK = cell.FLOAT_TICK
SETTING = float(cell.SETTING)
MAKING_A_STEP = float(cell.MAKING_A_STEP)
GETTING = float(cell.GETTING)

ANSWERS = 32  # bytes, see `operations.heed`


@inlined
def copy(row: int, behind: int, conversions: int, values: int) -> None:
    """Execute the rows of `copies` from an address to the one behind, between `values`."""
    while row < behind:
        conversion = row_at(conversions, 2, whole(row, 2))
        factor, offset = load(conversion, 0, FLOAT64), load(conversion, 1, FLOAT64)
        store(values, whole(row, 1), FLOAT64, factor * load(values, whole(row, 0), FLOAT64) + offset)
        row = row_at(row, COPY_WIDTH, 1)


@inlined
def record(row: int, values: int, observed: tuple[int, int], n: tuple[int, int]) -> int:
    """
    Record one row of results; all but the two numbers are addresses.

    Args:
        row: The row.
        values: The table of values.
        observed: Places of the signals in it, their largest allowed magnitudes.
        n: Number of signals that are the first places in order, which are copied as one; number of all.

    Returns:
        Number of values beyond their limits or not finite.
    """
    places, limits = observed
    n_beyond = 0
    copy_cells(row, values, n[0])
    for j in range(n[0]):  # reads only: a loop that vectors run through
        n_beyond += not abs(load(values, j, FLOAT64)) <= load(limits, j, FLOAT64)
    for j in range(n[0], n[1]):
        value = load(values, whole(places, j), FLOAT64)
        store(row, j, FLOAT64, value)
        n_beyond += not abs(value) <= load(limits, j, FLOAT64)
    return n_beyond


@inlined
def turn(
    row: int,
    blocks: int,
    step: tuple[float, float],
    room: tuple[int, int],
    state: tuple[int, int],
    general: bool | None,
    position: int,
) -> tuple[int, int]:
    """
    Let an FMU take its turn; whatever it does to the floating-point mode is undone.

    Args:
        row: Address of its row in `slaves`.
        blocks: Address of the table `blocks`.
        step: Start t and length h [s].
        room: Address of the values, and of `ANSWERS` bytes followed by room for a block of any type.
        state: Operation at which the end was asked for or -1, this operation.
        general: None if all FMUs are of FMI 2.0.
        position: Address of the cells of the run's position.

    Returns:
        Status and the first of `state` anew; see `heed`.
    """
    status, ended = _turn(row, blocks, step, room, state, general, position)
    if restore_float_mode() != 0:
        store(position, FLOAT_MODE, FLOAT64, load(position, SLAVE, FLOAT64) + 1.0)
        store(position, FLOAT_TICK, FLOAT64, load(position, TICK, FLOAT64))
    return status, ended


@inlined
def _turn(
    row: int,
    blocks: int,
    step: tuple[float, float],
    room: tuple[int, int],
    state: tuple[int, int],
    general: bool | None,
    position: int,
) -> tuple[int, int]:
    """Set the inputs, step, and get the outputs, as far as the FMU answers well."""
    ended = state[0]
    store(position, PHASE, FLOAT64, SETTING)
    slave = (whole(row, 0), 2 if general is None else whole(row, 1))
    for j in range(whole(row, 3), whole(row, 4)):
        status = _set(slave, row_at(blocks, BLOCK_WIDTH, j), room[0], room[1] + ANSWERS)
        if status > WARNING:
            return status, ended
    store(position, PHASE, FLOAT64, MAKING_A_STEP)
    if general is None:
        status = calls.do_step(whole(row, 2), slave[0], step[0], step[1])
    else:
        status, ended = _do_step(slave, whole(row, 2), step, room[1], state)
    if status > WARNING:
        return status, ended
    store(position, PHASE, FLOAT64, GETTING)
    for j in range(whole(row, 5), whole(row, 6)):
        status = _get(slave, row_at(blocks, BLOCK_WIDTH, j), room[0], room[1] + ANSWERS)
        if status > WARNING:
            return status, ended
    return 0, ended


@inlined
def _exchange(slave: tuple[int, int], block: int, data: int) -> int:
    """Call a setter or getter: `slave` is (component, version), `block` the address of its row."""
    function, references, n = whole(block, 0), whole(block, 1), whole(block, 2)
    if slave[1] == 2:
        return calls.exchange(function, slave[0], references, n, data)
    return calls.exchange_3(function, slave[0], references, n, data, whole(block, 3))


@inlined
def _set(slave: tuple[int, int], block: int, values: int, typed: int) -> int:
    """Set a block from the doubles of the table at `values`; other types pass through memory at `typed`."""
    kind, data = whole(block, 4), row_at(values, 1, whole(block, 5))
    if kind == FLOAT64:
        return _exchange(slave, block, data)
    if not pack(data, whole(block, 3), kind, typed):
        return MISFIT
    return _exchange(slave, block, typed)


@inlined
def _get(slave: tuple[int, int], block: int, values: int, typed: int) -> int:
    """Get a block, the other way."""
    kind, data = whole(block, 4), row_at(values, 1, whole(block, 5))
    if kind == FLOAT64:
        return _exchange(slave, block, data)
    status = _exchange(slave, block, typed)
    unpack(data, whole(block, 3), kind, typed)
    return status


@inlined
def _do_step(
    slave: tuple[int, int], function: int, step: tuple[float, float], answers: int, state: tuple[int, int]
) -> tuple[int, int]:
    """Make the step with an FMU of either version; see `turn` and `heed`."""
    if slave[1] == 2:
        return calls.do_step(function, slave[0], step[0], step[1]), state[0]
    status = calls.do_step_3(function, slave[0], step[0], step[1], answers)
    if asks(answers):
        return heed(slave, function, step, answers, (status, state[0], state[1]))
    return status, state[0]

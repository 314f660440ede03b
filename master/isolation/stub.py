"""
The functions of an isolated FMU as the stepping loop calls them: compiled, in the form of FMI 2.0 and 3.0.

They pass on what they are asked to the FMU's process and wait for its answer; see `layout`.
"""

from __future__ import annotations

from master.fmi.native.cells import integer_at, load, store
from master.fmi.native.jit import inner
from master.fmi.native.sharing import (
    KILL,
    WAIT4,
    copy_bytes,
    kernel,
    load_word,
    looked,
    now,
    publish,
    put_integer,
    sleep_on,
)
from master.fmi.value_types import FLOAT64, UINT8
from master.process import position as cell

from . import layout as at
from .layout import Fault, Request

# As numbers of their own, for compiled code.
STEP, APPLY, GET, SAVE, RESTORE, FREE = map(int, list(Request)[:6])
NONE, ENDED, HUNG, REFUSED = map(int, Fault)
LOST = at.LOST
TICK = cell.TICK
DISCARD = 2
NO_HANG = 1  # WNOHANG
SIGKILL = 9
SLICE = 10_000_000  # ns between two looks at whether the process is there
HELD_STATE = 1


@inner
def _fail(desk: int, fault: int, status: int) -> int:
    put_integer(desk, at.FAULT, fault)
    put_integer(desk, at.FAULT_STATUS, status)
    put_integer(desk, at.FAULT_TICK, int(load(integer_at(desk, at.POSITION), TICK, FLOAT64)))
    return LOST


@inner
def _look_at_process(desk: int) -> bool:
    """Whether the FMU's process has ended; how is in the desk then."""
    process, entry = integer_at(desk, at.PROCESS), integer_at(desk, at.KERNEL)
    if process <= 0:
        return True
    status_at = desk + 8 * at.WAIT_STATUS
    if kernel(entry, WAIT4, process, status_at, NO_HANG, desk + 8 * at.USAGE) != process:
        return False
    put_integer(desk, at.PROCESS, 0)
    return True


@inner
def ask(desk: int, operation: int) -> int:
    """Make a request and wait for its answer; 0, or LOST if the process ended or did not answer in time."""
    if integer_at(desk, at.FAULT) != NONE:
        return LOST
    channel, entry = integer_at(desk, at.CHANNEL), integer_at(desk, at.KERNEL)
    put_integer(channel, at.OPERATION, operation)
    put_integer(channel, at.N_SETS, integer_at(desk, at.N_SET))
    put_integer(channel, at.N_GETS, integer_at(desk, at.N_PLANNED))
    store(channel, at.TICK, FLOAT64, load(integer_at(desk, at.POSITION), TICK, FLOAT64))
    before = integer_at(desk, at.SEQUENCE)
    number = (before + 1) & 0xFFFFFFFF
    put_integer(desk, at.SEQUENCE, number)
    put_integer(desk, at.N_SET, 0)
    put_integer(desk, at.SETS_USED, 0)
    put_integer(desk, at.IS_FRESH, 0)
    publish(entry, channel + at.REQUEST, channel + at.REQUEST_SLEEPS, number)
    word, scratch = channel + at.ANSWER, desk + 8 * at.SCRATCH
    if looked(entry, word, before, integer_at(desk, at.LOOKS)):
        return 0
    began = 0
    while load_word(word) == before:
        sleep_on(entry, word, channel + at.ANSWER_SLEEPS, before, SLICE, scratch)
        if load_word(word) != before:
            break
        present = now(entry, scratch)
        began = present if began == 0 else began
        if _look_at_process(desk):
            if load_word(word) != before:
                break
            return _fail(desk, ENDED, LOST)
        if present - began > integer_at(desk, at.DEADLINE):
            process = integer_at(desk, at.PROCESS)
            kernel(entry, KILL, process, SIGKILL, 0, 0)
            kernel(entry, WAIT4, process, desk + 8 * at.WAIT_STATUS, 0, desk + 8 * at.USAGE)
            put_integer(desk, at.PROCESS, 0)
            return _fail(desk, HUNG, LOST)
    return 0


@inner
def _is_held(desk: int) -> bool:
    """Whether the FMU failed and its last values are to be held."""
    has_failed = integer_at(desk, at.FAULT) != NONE
    return has_failed and integer_at(desk, at.HOLDS) != 0 and integer_at(desk, at.N_STEPS) > 0


@inner
def _write_entry(entry: int, kind: int, size: int, references: int, n: int, n_values: int) -> int:
    """Write the cells and references of an entry; return the address of its values."""
    values_at = 8 * at.ENTRY_CELLS + 8 * ((4 * n + 7) // 8)
    put_integer(entry, at.ENTRY_TYPE, kind)
    put_integer(entry, at.ENTRY_N, n)
    put_integer(entry, at.ENTRY_N_VALUES, n_values)
    put_integer(entry, at.ENTRY_VALUES_AT, values_at)
    put_integer(entry, at.ENTRY_NEXT, values_at + 8 * ((size * n_values + 7) // 8))
    copy_bytes(entry + 8 * at.ENTRY_CELLS, references, 4 * n)
    return entry + values_at


@inner
def _length(size: int, n: int, n_values: int) -> int:
    """Bytes of an entry."""
    return 8 * at.ENTRY_CELLS + 8 * ((4 * n + 7) // 8) + 8 * ((size * n_values + 7) // 8)


@inner
def put(desk: int, kind: int, size: int, references: int, n: int, values: int, n_values: int) -> int:
    """Set values: they wait in the channel for the next step, or are set at once where it is full of them."""
    put_integer(desk, at.IS_FRESH, 0)
    if integer_at(desk, at.FAULT) != NONE:
        return 0 if _is_held(desk) else LOST
    length = _length(size, n, n_values)
    if integer_at(desk, at.SETS_USED) + length > integer_at(desk, at.SETS_BYTES):
        status = _answered(desk, APPLY)
        if status != 0:
            return status
    used = integer_at(desk, at.SETS_USED)
    entry = integer_at(desk, at.CHANNEL) + integer_at(desk, at.SETS_AT) + used
    copy_bytes(_write_entry(entry, kind, size, references, n, n_values), values, size * n_values)
    put_integer(desk, at.SETS_USED, used + length)
    put_integer(desk, at.N_SET, integer_at(desk, at.N_SET) + 1)
    return 0


@inner
def _with_fault(desk: int, status: int) -> int:
    """Let an FMU whose values are to be held fail where it answers with an error; return the status."""
    is_fault = (status & ~1) != 0 and status != DISCARD
    if is_fault and integer_at(desk, at.HOLDS) != 0 and integer_at(desk, at.N_STEPS) > 0:
        _fail(desk, REFUSED, status)
    return status


@inner
def _answered(desk: int, operation: int) -> int:
    """Make a request; the status that the FMU answered with, 0 where its values are held."""
    status = ask(desk, operation)
    if status == 0:
        status = _with_fault(desk, integer_at(integer_at(desk, at.CHANNEL), at.STATUS))
    return 0 if _is_held(desk) else status


@inner
def _planned(desk: int, kind: int, references: int, n: int, n_values: int) -> int:
    """Address of the row of the plan for an output, 0 if there is none."""
    row = integer_at(desk, at.PLAN)
    for _ in range(integer_at(desk, at.N_PLANNED)):
        if (
            integer_at(row, at.PLAN_REFERENCES) == references
            and integer_at(row, at.PLAN_N) == n
            and integer_at(row, at.PLAN_N_VALUES) == n_values
            and integer_at(row, at.PLAN_TYPE) == kind
        ):
            return row
        row += 8 * at.PLAN_WIDTH
    return 0


@inner
def _plan(desk: int, kind: int, size: int, references: int, n: int, n_values: int) -> int:
    """Add an output to the plan; the address of its row, 0 if there is no room."""
    planned, used = integer_at(desk, at.N_PLANNED), integer_at(desk, at.GETS_USED)
    length = _length(size, n, n_values)
    if planned == at.MOST_PLANNED or used + length > integer_at(desk, at.GETS_BYTES):
        return 0
    entry = integer_at(desk, at.CHANNEL) + integer_at(desk, at.GETS_AT) + used
    row = integer_at(desk, at.PLAN) + 8 * at.PLAN_WIDTH * planned
    put_integer(row, at.PLAN_TYPE, kind)
    put_integer(row, at.PLAN_REFERENCES, references)
    put_integer(row, at.PLAN_N, n)
    put_integer(row, at.PLAN_N_VALUES, n_values)
    put_integer(row, at.PLAN_ENTRY, entry)
    put_integer(row, at.PLAN_VALUES, _write_entry(entry, kind, size, references, n, n_values))
    put_integer(row, at.PLAN_BYTES, size * n_values)
    put_integer(row, at.PLAN_IS_HELD, 0)
    put_integer(desk, at.GETS_USED, used + length)
    put_integer(desk, at.N_PLANNED, planned + 1)
    return row


@inner
def _hold(desk: int, row: int, values: int, is_back: bool) -> None:
    """Keep the values of an output where the FMU cannot reach them, or bring them back."""
    offset = integer_at(row, at.PLAN_VALUES) - integer_at(desk, at.CHANNEL) - integer_at(desk, at.GETS_AT)
    kept = integer_at(desk, at.HELD) + offset
    if is_back:
        copy_bytes(values, kept, integer_at(row, at.PLAN_BYTES))
    else:
        copy_bytes(kept, values, integer_at(row, at.PLAN_BYTES))
        put_integer(row, at.PLAN_IS_HELD, 1)


@inner
def take(desk: int, kind: int, size: int, references: int, n: int, values: int, n_values: int) -> int:
    """Get values: those that the last step brought, else by a request."""
    row = _planned(desk, kind, references, n, n_values)
    if row == 0:
        row = _plan(desk, kind, size, references, n, n_values)
        put_integer(desk, at.IS_FRESH, 0)
    if row == 0:
        return LOST
    if integer_at(desk, at.IS_FRESH) == 0 and not _is_held(desk):
        number = (row - integer_at(desk, at.PLAN)) // (8 * at.PLAN_WIDTH)
        put_integer(integer_at(desk, at.CHANNEL), at.WHICH, number)
        status = _answered(desk, GET)
        if (status & ~1) != 0:
            return status
    status = 0
    if not _is_held(desk):
        status = _with_fault(desk, integer_at(integer_at(row, at.PLAN_ENTRY), at.ENTRY_STATUS))
    if _is_held(desk):
        if integer_at(row, at.PLAN_IS_HELD) == 0:
            return LOST
        _hold(desk, row, values, True)
        return 0
    copy_bytes(values, integer_at(row, at.PLAN_VALUES), integer_at(row, at.PLAN_BYTES))
    if integer_at(desk, at.HOLDS) != 0 and (status & ~1) == 0:
        _hold(desk, row, values, False)
    return status


@inner
def exchange(
    is_get: int,
    kind: int,
    size: int,
    desk: int,
    references: int,
    n: int,
    values: int,
    n_values: int,
) -> int:
    """Set or get values of a type whose values have `size` bytes."""
    if is_get != 0:
        return take(desk, kind, size, references, n, values, n_values)
    return put(desk, kind, size, references, n, values, n_values)


@inner
def _step(desk: int, t: float, h: float) -> int:
    channel = integer_at(desk, at.CHANNEL)
    store(channel, at.TIME, FLOAT64, t)
    store(channel, at.LENGTH, FLOAT64, h)
    status = _answered(desk, STEP)
    if integer_at(desk, at.FAULT) == NONE and (status & ~1) == 0:
        put_integer(desk, at.IS_FRESH, 1)
        put_integer(desk, at.N_STEPS, integer_at(desk, at.N_STEPS) + 1)
    return status


@inner
def step_2(desk: int, t: float, h: float, _: int) -> int:
    """Step from t to t + h [s], as fmi2DoStep."""
    return _step(desk, t, h)


@inner
def step_3(desk: int, t: float, h: float, _: int, events: int, end: int, early: int, last: int) -> int:
    """Step from t to t + h [s], as fmi3DoStep."""
    status = _step(desk, t, h)
    is_answered = integer_at(desk, at.FAULT) == NONE
    channel = integer_at(desk, at.CHANNEL)
    for j, place in enumerate((events, end, early)):
        flag = load(channel + 8 * (at.FLAGS + j), 0, UINT8) if is_answered else 0.0
        store(place, 0, UINT8, 1.0 if flag != 0.0 else 0.0)
    store(last, 0, FLOAT64, load(channel, at.FLAGS + 3, FLOAT64) if is_answered else t + h)
    return status


@inner
def save(desk: int, cell: int) -> int:
    """Save the state of the FMU, as fmi2GetFMUstate: the cell gets its address in the FMU's process."""
    channel = integer_at(desk, at.CHANNEL)
    put_integer(channel, at.STATE, integer_at(cell, 0))
    status = _answered(desk, SAVE)
    put_integer(cell, 0, HELD_STATE if _is_held(desk) else integer_at(channel, at.STATE))
    return status


@inner
def restore(desk: int, state: int) -> int:
    """Put a state back, as fmi2SetFMUstate."""
    put_integer(integer_at(desk, at.CHANNEL), at.STATE, state)
    return _answered(desk, RESTORE)


@inner
def free(desk: int, cell: int) -> int:
    """Free a state, as fmi2FreeFMUstate."""
    put_integer(integer_at(desk, at.CHANNEL), at.STATE, integer_at(cell, 0))
    status = _answered(desk, FREE)
    put_integer(cell, 0, 0)
    return status

"""What the process of an isolated FMU does with a request: compiled, until one comes that Python answers."""

from __future__ import annotations

from master.fmi.native import calls
from master.fmi.native.cells import integer_at, load, store
from master.fmi.native.float_mode import restore_float_mode
from master.fmi.native.jit import inner
from master.fmi.native.sharing import GETPPID, kernel, load_word, looked, publish, put_integer, sleep_on
from master.fmi.value_types import FLOAT64
from master.process import position as cell

from . import layout as at
from .layout import Request

# As numbers of their own, for compiled code.
STEP, APPLY, GET, SAVE, RESTORE, FREE, CALL = map(int, Request)
PHASE = cell.PHASE
TICK = cell.TICK
FLOAT_MODE = cell.FLOAT_MODE
FLOAT_TICK = cell.FLOAT_TICK
OUTSIDE = float(cell.OUTSIDE)
SETTING = float(cell.SETTING)
MAKING_A_STEP = float(cell.MAKING_A_STEP)
GETTING = float(cell.GETTING)
SAVING = float(cell.SAVING)
RESTORING = float(cell.RESTORING)
OF_SET, OF_STEP, OF_GET, OF_SAVE, OF_RESTORE = range(5)
A_SECOND = 1_000_000_000  # ns
ORPHANED, ASKED, LAST = range(3)


@inner
def _exchange(desk: int, functions: int, entry: int) -> int:
    """Call the setter or getter of an entry's type."""
    function = integer_at(desk, functions + integer_at(entry, at.ENTRY_TYPE))
    component, references = integer_at(desk, at.COMPONENT), entry + 8 * at.ENTRY_CELLS
    n, values = integer_at(entry, at.ENTRY_N), entry + integer_at(entry, at.ENTRY_VALUES_AT)
    if integer_at(desk, at.VERSION) == 2:
        return calls.exchange(function, component, references, n, values)
    n_values = integer_at(entry, at.ENTRY_N_VALUES)
    return calls.exchange_3(function, component, references, n, values, n_values)


@inner
def _set_all(desk: int, channel: int, position: int) -> int:
    """Set what waits; the status of the first setter that fails, else 0."""
    store(position, PHASE, FLOAT64, SETTING)
    entry = channel + integer_at(desk, at.SETS_AT)
    for _ in range(integer_at(channel, at.N_SETS)):
        status = _exchange(desk, at.SETTERS, entry)
        if (status & ~1) != 0:
            return status
        entry += integer_at(entry, at.ENTRY_NEXT)
    return 0


@inner
def _get_all(desk: int, channel: int, position: int, only: int) -> None:
    """Get the outputs of the plan, or one of them (`only`, -1 for all); each entry has its status."""
    store(position, PHASE, FLOAT64, GETTING)
    entry = channel + integer_at(desk, at.GETS_AT)
    for j in range(integer_at(channel, at.N_GETS)):
        if only < 0 or only == j:
            status = _exchange(desk, at.GETTERS, entry)
            put_integer(entry, at.ENTRY_STATUS, status)
            if only < 0 and (status & ~1) != 0:
                return
        entry += integer_at(entry, at.ENTRY_NEXT)


@inner
def _step(desk: int, channel: int, position: int) -> int:
    store(position, PHASE, FLOAT64, MAKING_A_STEP)
    t, h = load(channel, at.TIME, FLOAT64), load(channel, at.LENGTH, FLOAT64)
    function, component = integer_at(desk, at.DO_STEP), integer_at(desk, at.COMPONENT)
    if integer_at(desk, at.VERSION) == 2:
        return calls.do_step(function, component, t, h)
    answers = channel + 8 * at.FLAGS
    for j in range(4):
        put_integer(answers, j, 0)
    return calls.do_step_3(function, component, t, h, answers)


@inner
def _state(desk: int, channel: int, position: int, operation: int) -> int:
    component = integer_at(desk, at.COMPONENT)
    store(position, PHASE, FLOAT64, RESTORING if operation == RESTORE else SAVING)
    if operation == RESTORE:
        return calls.state(integer_at(desk, at.SET_STATE), component, integer_at(channel, at.STATE))
    function = integer_at(desk, at.GET_STATE if operation == SAVE else at.FREE_STATE)
    return calls.state(function, component, channel + 8 * at.STATE)


@inner
def _do(desk: int, channel: int, operation: int) -> None:
    """Do what is asked, and write its status."""
    position = integer_at(desk, at.POSITION)
    store(position, TICK, FLOAT64, load(channel, at.TICK, FLOAT64))
    call = OF_SET
    status = _set_all(desk, channel, position)
    if (status & ~1) == 0:
        if operation == STEP:
            call = OF_STEP
            status = _step(desk, channel, position)
            if (status & ~1) == 0:
                _get_all(desk, channel, position, -1)
        elif operation == GET:
            call = OF_GET
            _get_all(desk, channel, position, integer_at(channel, at.WHICH))
        elif operation != APPLY:
            call = OF_RESTORE if operation == RESTORE else OF_SAVE
            status = _state(desk, channel, position, operation)
    put_integer(channel, at.STATUS, status)
    put_integer(channel, at.CALL, call)
    if restore_float_mode() != 0 and load(position, FLOAT_MODE, FLOAT64) == 0.0:
        store(position, FLOAT_MODE, FLOAT64, 1.0)
        store(position, FLOAT_TICK, FLOAT64, load(position, TICK, FLOAT64))
    store(position, PHASE, FLOAT64, OUTSIDE)


@inner
def serve(desk: int) -> int:
    """
    Answer requests until one comes that Python has to answer (1), or the stepping process is gone (0).

    At the next call that request is answered first; with IS_ASKED = LAST nothing follows then.
    """
    channel, entry = integer_at(desk, at.CHANNEL), integer_at(desk, at.KERNEL)
    word, scratch = channel + at.REQUEST, desk + 8 * at.SCRATCH
    number = integer_at(desk, at.SEQUENCE)
    asked = integer_at(desk, at.IS_ASKED)
    if asked != 0:
        put_integer(desk, at.IS_ASKED, 0)
        publish(entry, channel + at.ANSWER, channel + at.ANSWER_SLEEPS, number)
    if asked == LAST:
        return ORPHANED
    while True:
        if not looked(entry, word, number, integer_at(desk, at.LOOKS)):
            while load_word(word) == number:
                sleep_on(entry, word, channel + at.REQUEST_SLEEPS, number, A_SECOND, scratch)
                if kernel(entry, GETPPID, 0, 0, 0, 0) != integer_at(desk, at.PARENT):
                    return ORPHANED
        number = load_word(word)
        put_integer(desk, at.SEQUENCE, number)
        operation = integer_at(channel, at.OPERATION)
        if operation == CALL:
            put_integer(desk, at.IS_ASKED, ASKED)
            return ASKED
        _do(desk, channel, operation)
        publish(entry, channel + at.ANSWER, channel + at.ANSWER_SLEEPS, number)

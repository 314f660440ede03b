"""
Where a run is: which FMU, which of its functions, which tick.

A run writes it down before each call, so that a message can be assigned to its call, and so that another
process that shares the memory can say what went wrong where the process ended within an FMU.
"""

from __future__ import annotations

import ctypes
import json
import math
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import Any, NamedTuple

TICK, SLAVE, PHASE, STAGE, WRITTEN, CONSUMED, STOP, FINISHED, FLOAT_MODE, FLOAT_TICK, T0, STEP_SIZE = range(
    12
)
_N_CELLS = 16
_TEXT = 8 * _N_CELLS
_TEXT_BYTES = 512
_SLAVES = _TEXT + 2 * _TEXT_BYTES
_SLAVES_BYTES = 2**20
N_BYTES = _SLAVES + _SLAVES_BYTES

LOADING, STEPPING, ENDING = range(3)  # stages of a run
OUTSIDE, SETTING, MAKING_A_STEP, GETTING, SAVING, RESTORING = range(6)  # calls that the stepping loop makes

_FUNCTIONS = {
    2: {
        SETTING: "fmi2SetXXX",
        MAKING_A_STEP: "fmi2DoStep",
        GETTING: "fmi2GetXXX",
        SAVING: "fmi2GetFMUstate",
        RESTORING: "fmi2SetFMUstate",
    },
    3: {
        SETTING: "fmi3SetXXX",
        MAKING_A_STEP: "fmi3DoStep",
        GETTING: "fmi3GetXXX",
        SAVING: "fmi3GetFMUState",
        RESTORING: "fmi3SetFMUState",
    },
}

Slaves = Sequence[tuple[str, int]]
"""Instance and FMI version, in the order of their numbers in a program."""


class Interrupted(Exception):  # noqa: N818 - it is no error: a run that was asked to end
    """A run that is asked to end before it steps."""


class Call(NamedTuple):
    """A call of an FMU: instance, function, the tick in which it is made, whether by the stepping loop."""

    instance: str
    function: str
    tick: int
    is_in_loop: bool = False


class Position:
    """
    Present call of a run, in memory that may be shared.

    `cells` are numbers that compiled code writes too, at the indices named above; FLOAT_MODE is 1 + the
    number of the first slave that changed the floating-point mode, FLOAT_TICK the tick in which it did.
    Tick k is at T0 + k STEP_SIZE [s].
    """

    def __init__(self, memory: Any | None = None) -> None:
        self._memory = bytearray(N_BYTES) if memory is None else memory
        self.cells = memoryview(self._memory)[:_TEXT].cast("d")
        self.cells[T0] = math.nan
        self._slaves: Slaves = ()

    def begin(self, t0: float, step_size: float) -> None:
        """Note that a run begins at t0 [s] with its step size [s]; what an earlier one left is forgotten."""
        self.leave()
        self.cells[STOP] = 0.0
        self.cells[FLOAT_MODE] = 0.0
        self.cells[PHASE] = OUTSIDE
        self.cells[TICK] = 0.0
        self.cells[T0] = t0
        self.cells[STEP_SIZE] = step_size
        self.cells[STAGE] = LOADING

    def step(self, slaves: Slaves, t0: float, step_size: float) -> None:
        """Note that the stepping loop is about to call some FMUs, on a grid of ticks from t0 [s]."""
        self.cells[T0] = t0
        self.cells[STEP_SIZE] = step_size
        if slaves is not self._slaves:
            self._slaves = slaves
            data = json.dumps(list(slaves)).encode()
            self._put(_SLAVES, data if len(data) < _SLAVES_BYTES else b"[]")

    def recall(self, slave: int, tick: int) -> None:
        """Note an earlier step of an FMU as the present call."""
        self.cells[SLAVE] = slave
        self.cells[PHASE] = MAKING_A_STEP
        self.cells[TICK] = tick

    def rest(self, tick: int) -> None:
        """Note that the stepping loop has come to a tick and calls no FMU."""
        self.cells[PHASE] = OUTSIDE
        self.cells[TICK] = tick

    def enter(self, instance: str, function: str) -> None:
        """Note a call that is made outside the stepping loop."""
        self._write(0, instance)
        self._write(1, function)

    def leave(self) -> None:
        """Note that no such call is going on."""
        self._write(1, "")

    def call(self) -> Call | None:
        """Return the present call, None if there is none."""
        tick = int(self.cells[TICK])
        function = self._read(1)
        if function:
            return Call(self._read(0), function, tick)
        phase = int(self.cells[PHASE])
        if phase == OUTSIDE:
            return None
        slaves = self._slaves or json.loads(self._get(_SLAVES, _SLAVES_BYTES) or b"[]")
        number = int(self.cells[SLAVE])
        if number >= len(slaves):
            return None
        instance, version = slaves[number]
        return Call(instance, _FUNCTIONS[version][phase], tick, is_in_loop=True)

    def time(self) -> float | None:
        """Time of the present tick [s], None before a run begins."""
        t = self.cells[T0] + self.cells[TICK] * self.cells[STEP_SIZE]
        return None if math.isnan(t) else t

    def address(self) -> int:
        """Address of the cells."""
        return ctypes.addressof(ctypes.c_char.from_buffer(self._memory))

    def check_stop(self) -> None:
        """Raise Interrupted if the run is asked to end before it steps; the stepping loop looks itself."""
        if self.cells[STOP] and self.cells[STAGE] == LOADING:
            raise Interrupted

    def _write(self, place: int, text: str) -> None:
        data = text.encode("utf-8", errors="replace")[: _TEXT_BYTES - 1]
        self._put(_TEXT + place * _TEXT_BYTES, data)

    def _read(self, place: int) -> str:
        return self._get(_TEXT + place * _TEXT_BYTES, _TEXT_BYTES).decode("utf-8", errors="replace")

    def _put(self, first: int, data: bytes) -> None:
        self._memory[first : first + len(data) + 1] = data + b"\0"

    def _get(self, first: int, most: int) -> bytes:
        end = self._memory.find(b"\0", first, first + most)
        return bytes(self._memory[first:end])


_current = Position()


def current() -> Position:
    """Return the position of the run in this process."""
    return _current


@contextmanager
def using(position: Position) -> Iterator[Position]:
    """Let this process write its position there."""
    global _current
    before = _current
    _current = position
    try:
        yield position
    finally:
        _current = before

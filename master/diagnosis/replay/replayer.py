"""
Replay at the speed of C: a chain of FMUs is stepped over arrays of measured inputs.

The functions of the FMUs are called by address from one compiled loop, as in `master/stepping/loop.py`, but
the inputs come from a table and the outputs go to one: a replay of 10 000 steps takes some 10 ms.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from master.diagnosis.numerics.arrays import Array
from master.errors import ConfigError, FmuError
from master.fmi.description import Description, Kind, Variable
from master.fmi.fmi2 import Fmi2Slave
from master.fmi.native import calls
from master.fmi.value_types import FLOAT64

Integers = NDArray[np.int64]
MEASURED, WIRED = 0, 1
WARNING = 1
COMPONENT, STEP, SET, GET, INPUTS, N_INPUTS, FIRST_INPUT = range(7)
OUTPUTS, N_OUTPUTS, FIRST_OUTPUT, MOVE, END_MOVE = range(7, 12)
TARGET, KIND, SOURCE = range(3)
_REAL = (Kind.REAL, FLOAT64)


class Layout(NamedTuple):
    """
    What the loop works on.

    `fmus`: a row an FMU with the columns COMPONENT to END_MOVE. `moves`: [target, kind, source], the
    source a column of the data (MEASURED) or a place in `table` (WIRED). `places`: what is read.
    """

    fmus: Integers
    moves: Integers
    places: Integers
    table: Array


@dataclass(frozen=True)
class Link:
    """One FMU of a chain: what drives its inputs and what is read from it."""

    name: str
    description: Description
    measured: Mapping[str, int]
    wired: Mapping[str, str]
    read: tuple[str, ...]


class _Slave(Fmi2Slave):
    def restart(self, start: Mapping[str, float | str], t0: float) -> None:
        self._messages.clear()
        self._call(self._fmu.reset)
        self.enter_initialisation(start, t0)


def _play(layout, data, out, grid, clock):  # type: ignore[no-untyped-def]  # compiled
    table, moves = layout.table, layout.moves
    first, n, every = grid
    t0, h = clock
    for j in range(n):
        for i in range(len(layout.fmus)):
            fmu = layout.fmus[i]
            for q in range(fmu[MOVE], fmu[END_MOVE]):
                if moves[q, KIND] == MEASURED:
                    table[moves[q, TARGET]] = data[first + j + 1, moves[q, SOURCE]]
                else:
                    table[moves[q, TARGET]] = table[moves[q, SOURCE]]
            at = table.ctypes.data
            if fmu[N_INPUTS] > 0:
                inputs = at + 8 * fmu[FIRST_INPUT]
                calls.exchange(fmu[SET], fmu[COMPONENT], fmu[INPUTS], fmu[N_INPUTS], inputs)
            if calls.do_step(fmu[STEP], fmu[COMPONENT], t0 + j * h, h) > WARNING:
                return j
            if fmu[N_OUTPUTS] > 0:
                outputs = at + 8 * fmu[FIRST_OUTPUT]
                calls.exchange(fmu[GET], fmu[COMPONENT], fmu[OUTPUTS], fmu[N_OUTPUTS], outputs)
        if (j + 1) % every == 0:
            for q in range(len(layout.places)):
                out[(j + 1) // every, q] = table[layout.places[q]]
    return n


@cache
def _compiled() -> Any:
    from numba import njit

    return njit(cache=True)(_play)


class Player:
    """
    A chain of loaded FMUs; `names` are the signals that a replay gives, `instance.variable`.

    Raises:
        FmuError: If one cannot be loaded.
    """

    def __init__(self, chain: Sequence[Link]) -> None:
        self.chain = list(chain)
        self.slaves: list[_Slave] = []
        self.names = [f"{link.name}.{variable}" for link in chain for variable in link.read]
        try:
            for link in chain:
                if link.description.version != 2:
                    version = link.description.fmi_version
                    raise ConfigError([f"{link.name}: FMI version, got {version}, expected 2.0 for a replay"])
                self.slaves.append(_Slave(link.name, link.description))
            self._lay_out()
        except BaseException:  # Ctrl-C too: nobody else could unload them
            self.close()
            raise

    def play(
        self,
        values: Mapping[str, Mapping[str, float | str]],
        data: Array,
        segment: tuple[int, int],
        step: float,
        every: int = 1,
    ) -> Array:
        """
        Replay one stretch from initialised FMUs; shape (rows, names), NaN from a failure on.

        Args:
            values: FMU to parameters and start values.
            data: Measured inputs at every step, shape (steps + 1, columns).
            segment: First row and number of steps in `data`.
            step: Length of a step [s].
            every: Steps from one row of the result to the next.
        """
        first, n = segment
        out = np.full((n // every + 1, len(self.names)), np.nan)
        try:
            self._initialise(values, data[first], first * step)
        except FmuError:
            return out
        out[0] = self.layout.table[self.layout.places]
        _compiled()(self.layout, data, out, (first, n, every), (first * step, step))
        return out

    def last_message(self) -> str:
        """What the FMUs said last, empty if nothing."""
        said = [slave.last_message() for slave in self.slaves]
        return next((message for message in said if message), "")

    def close(self) -> None:
        """Unload the FMUs."""
        for slave in self.slaves:
            slave.close(failed=False)
        self.slaves = []

    def _initialise(self, values: Mapping[str, Mapping[str, float | str]], row: Array, t0: float) -> None:
        table = self.layout.table
        for fmu, slave, link in zip(self.layout.fmus, self.slaves, self.chain, strict=True):
            slave.restart(values.get(link.name, {}), t0)
            for target, kind, source in self.layout.moves[fmu[MOVE] : fmu[END_MOVE]]:
                table[target] = row[source] if kind == MEASURED else table[source]
            at = table.ctypes.data
            if fmu[N_INPUTS]:
                inputs = at + 8 * int(fmu[FIRST_INPUT])
                calls.exchange(fmu[SET], fmu[COMPONENT], fmu[INPUTS], fmu[N_INPUTS], inputs)
            slave.exit_initialisation()
            outputs = at + 8 * int(fmu[FIRST_OUTPUT])
            calls.exchange(fmu[GET], fmu[COMPONENT], fmu[OUTPUTS], fmu[N_OUTPUTS], outputs)

    def _lay_out(self) -> None:
        """Give every input and output a place in the table."""
        place: dict[str, int] = {}
        for link in self.chain:
            for variable in (*link.measured, *link.wired, *link.read):
                place.setdefault(f"{link.name}.{variable}", len(place))
        self._references: list[Any] = []
        fmus = np.zeros((len(self.chain), END_MOVE + 1), dtype=np.int64)
        moves: list[tuple[int, int, int]] = []
        for i, (link, slave) in enumerate(zip(self.chain, self.slaves, strict=True)):
            c = slave.interface()
            begin = len(moves)
            for v, column in link.measured.items():
                moves.append((place[f"{link.name}.{v}"], MEASURED, column))
            for v, source in link.wired.items():
                moves.append((place[f"{link.name}.{v}"], WIRED, place[source]))
            inputs, outputs = [*link.measured, *link.wired], list(link.read)
            fmus[i, : GET + 1] = (c.component, c.do_step, c.setters[_REAL], c.getters[_REAL])
            at = moves[begin][0] if inputs else 0
            fmus[i, INPUTS : FIRST_INPUT + 1] = (self._addresses(link, inputs), len(inputs), at)
            at = place[f"{link.name}.{outputs[0]}"] if outputs else 0
            fmus[i, OUTPUTS : FIRST_OUTPUT + 1] = (self._addresses(link, outputs), len(outputs), at)
            fmus[i, MOVE:] = (begin, len(moves))
        self.layout = Layout(
            fmus=fmus,
            moves=np.array(moves or [(0, 0, 0)], dtype=np.int64).reshape(-1, 3),
            places=np.array([place[name] for name in self.names], dtype=np.int64),
            table=np.zeros(len(place)),
        )

    def _addresses(self, link: Link, names: Sequence[str]) -> int:
        references = np.array([_real(link, n).reference for n in names] or [0], dtype=np.uint32)
        self._references.append(references)
        return int(references.ctypes.data)


def _real(link: Link, name: str) -> Variable:
    variable = link.description.by_name[name]
    if variable.kind is not Kind.REAL:
        raise ConfigError([f"{link.name}.{name}: kind, got {variable.kind.value}, expected Real in a replay"])
    return variable

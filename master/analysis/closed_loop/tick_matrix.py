"""
One tick of the scheduled system as a matrix: the linear FMUs run through the operations of the schedule.

The total state is what the master and its FMUs carry from tick to tick: the states of all FMUs, the held
outputs (a target that steps before its source takes the value of the tick before), and the values under
way on delayed connections. A cut connection carries an outer signal r in place of its value v:

    w(k+1) = M w(k) + N r(k),   v(k) = P w(k) + Q r(k)
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from master.analysis.state_space import StateSpace
from master.coupling.extrapolation import one_step_on
from master.coupling.schedule import Schedule
from master.system.graph import System, Wire

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class LinearPart:
    """
    One FMU: its linear system and the names of its inputs and outputs, as columns and rows stand.

    One that varies with time has `systems`, one for each tick; the last `repeats` come again and again.
    """

    system: StateSpace
    inputs: tuple[str, ...]
    outputs: tuple[str, ...]
    systems: Sequence[StateSpace] = ()
    repeats: int = 1

    def at(self, k: int) -> StateSpace:
        """Give the linear system of tick k."""
        behind = k - len(self.systems)
        if not self.systems:
            return self.system
        return self.systems[k if behind < 0 else behind % self.repeats - self.repeats]


@dataclass(frozen=True)
class OpenedLoop:
    """
    The system with outer signals r on connections, and v, what the connections would carry.

    x(k + 1) = M x + N r, v = P x + Q r, a row of r and v for each connection.
    """

    M: Floats
    N: Floats
    P: Floats
    Q: Floats


@dataclass(frozen=True)
class LinearSystem:
    """Linear FMUs, wires and order; `extra` adds whole ticks of delay by the wire's target."""

    system: System
    schedule: Schedule
    parts: Mapping[str, LinearPart]
    step_size: float
    extra: Mapping[str, int]

    @property
    def period(self) -> int:
        """Ticks after which the order repeats."""
        return math.lcm(*self.schedule.every.values())

    @cached_property
    def wires(self) -> list[Wire]:
        """Connections of numbers that vary continuously."""
        return [w for w in self.system.wires if w.target.name in self._inputs]

    @cached_property
    def _inputs(self) -> set[str]:
        return {name for part in self.parts.values() for name in part.inputs}

    def delay_of(self, wire: Wire) -> int:
        """Whole ticks of a connection."""
        return wire.delay + self.extra.get(wire.target.name, 0)

    def owners(self) -> list[str]:
        """Name for each place of the total state: the FMU, or the connection on whose way the value is."""
        return [owner for owner, n in self.layout() for _ in range(n)]

    def layout(self) -> list[tuple[str, int]]:
        """Blocks of the total state: owner and size; states, held outputs, values under way or kept."""
        states = [(name, part.system.order) for name, part in self.parts.items()]
        held = [(name, len(part.outputs)) for name, part in self.parts.items()]
        under_way = [
            (f"{w.source.name} -> {w.target.name}", self.delay_of(w) + w.extrapolation) for w in self.wires
        ]
        return [*states, *held, *under_way]

    def matrix(self, first: int = 0, ticks: int | None = None) -> Floats:
        """Map the total state from a first tick over so many, or over one period."""
        n = len(self.owners())
        walk, total = TickPropagation(self, np.eye(n)), np.eye(n)
        for k in range(first, first + (ticks or self.period)):
            total = walk.run(k)
        return total

    def row(self, signal: str) -> Floats:
        """Row that reads a held output from the total state."""
        first = sum(part.system.order for part in self.parts.values())
        names = [name for part in self.parts.values() for name in part.outputs]
        row = np.zeros(len(self.owners()))
        row[first + names.index(signal)] = 1.0
        return row

    def opened(self, *wires: Wire, cut: bool) -> OpenedLoop:
        """Put r in place of the wires' values (`cut`) or on top of them; every FMU steps each tick."""
        n = len(self.owners())
        tick = TickPropagation(self, np.eye(n), {wire.target.name: cut for wire in wires})
        rows = tick.run(0)
        v = np.array([tick.arrived[wire.target.name] for wire in wires])
        return OpenedLoop(rows[:, :n], rows[:, n:], v[:, :n], v[:, n:])


class TickPropagation:
    """
    Carries a total state, or a basis of them, from tick to tick.

    Every quantity is a row: its coefficients over the columns of `start`, shape (total state, columns), over
    outer signals, and over unknowns of a loop.
    """

    def __init__(self, coupled: LinearSystem, start: Floats, outer: Mapping[str, bool] | None = None) -> None:
        self.coupled, self.outer = coupled, outer or {}
        n = start.shape[1]
        self.width, self.tick = n + len(self.outer), 0
        rows = _wide(start, self.width)
        self.signals = {name: np.eye(1, self.width, n + i)[0] for i, name in enumerate(self.outer)}
        blocks, place = [], 0
        for _, size in coupled.layout():
            blocks.append(rows[place : place + size])
            place += size
        n_parts, names = len(coupled.parts), list(coupled.parts)
        self.states = dict(zip(names, blocks[:n_parts], strict=True))
        self.held = dict(zip(names, blocks[n_parts : 2 * n_parts], strict=True))
        targets = [w.target.name for w in coupled.wires]
        self.under_way = dict(zip(targets, blocks[2 * n_parts :], strict=True))
        self.arrived: dict[str, Floats] = {}
        self.collected: dict[str, list[Floats]] = {}
        self._into: dict[str, list[Wire]] = {}
        for wire in coupled.wires:
            self._into.setdefault(wire.target.instance, []).append(wire)

    def run(self, k: int) -> Floats:
        """Execute tick k; give the rows of the new total state."""
        self.tick = k
        for group in self.coupled.schedule.groups:
            group.act(self, k, self.coupled.schedule.every)
        return np.concatenate([*self.states.values(), *self.held.values(), *self.under_way.values()])

    def wires_into(self, instance: str) -> Sequence[Wire]:
        """Connections of its inputs that vary continuously."""
        return self._into.get(instance, ())

    def delay_of(self, wire: Wire) -> int:
        """Whole ticks of delay of a connection."""
        return self.coupled.delay_of(wire)

    def step(self, instances: Sequence[str]) -> None:
        """Step side by side with the signals as they are."""
        for name in instances:
            self._step(name, self.width)

    def step_implicitly(self, instances: Sequence[str], inner: Sequence[Wire]) -> None:
        """Step side by side; `inner` wires carry the new values, as iteration to convergence gives them."""
        n, q = self.width, len(inner)
        for j, wire in enumerate(inner):
            self.signals[wire.target.name] = self._with_outer(wire, np.eye(1, n + q, n + j)[0])
        for name in instances:
            self._step(name, n + q)
        if not q:
            return
        sent = np.array([w.conversion.factor * self._source(w) for w in inner])
        solved = np.linalg.solve(np.eye(q) - sent[:, n:], sent[:, :n])
        for table in (self.states, self.held):
            for name in instances:
                table[name] = table[name][:, :n] + table[name][:, n:] @ solved
        for wire, value in zip(inner, solved, strict=True):
            self.arrived[wire.target.name] = value
            self.signals[wire.target.name] = self._with_outer(wire, value)

    def _source(self, wire: Wire) -> Floats:
        outputs = self.coupled.parts[wire.source.instance].outputs
        row: Floats = self.held[wire.source.instance][outputs.index(wire.source.name)]
        return row

    def transfer(self, wire: Wire) -> None:
        """Bring a connection's value to the input: through its delay, converted, extrapolated."""
        target, delay = wire.target.name, self.coupled.delay_of(wire)
        line = self.under_way[target]
        shifted = np.concatenate([self._source(wire)[None], line[:delay]])
        value = wire.conversion.factor * shifted[-1]
        self.arrived[target] = value
        value = self._with_outer(wire, value)
        past = line[delay:]
        kept = np.concatenate([value[None], past])[: len(past)]
        self.under_way[target] = np.concatenate([shifted[:-1], kept])
        self.signals[target] = _extrapolated(value, past)

    def _with_outer(self, wire: Wire, value: Floats) -> Floats:
        """Value that the target gets: with the outer signal on top or in its place."""
        target = wire.target.name
        if target not in self.outer:
            return value
        place = self.width - len(self.outer) + list(self.outer).index(target)
        outer: Floats = np.eye(1, len(value), place)[0]
        return outer if self.outer[target] else outer + value

    def _step(self, name: str, width: int) -> None:
        part = self.coupled.parts[name]
        system, x = part.at(self.tick), _wide(self.states[name], width)
        u = np.array([_wide(self.signals[i][None], width)[0] for i in part.inputs]).reshape(-1, width)
        self.states[name] = system.A @ x + system.B @ u
        self.held[name] = system.C @ x + system.D @ u


def _wide(rows: Floats, width: int) -> Floats:
    if rows.shape[1] == width:
        return rows
    padded: Floats = np.pad(rows, ((0, 0), (0, width - rows.shape[1])))
    return padded


def _extrapolated(value: Floats, past: Floats) -> Floats:
    """Polynomial through the last values, to the end of the step."""
    if len(past) == 0:
        return value
    return np.asarray(one_step_on(len(past), value, past[0], past[-1]))

"""
Replay at the speed of C: a chain of FMUs is stepped over arrays of measured inputs.

A replay is a program like a run (`master/stepping/machine`) whose inputs come from a table of measured
values; one of 10 000 steps takes some 10 ms.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from master.coupling.methods.catalogue import method_of
from master.coupling.schedule import Schedule
from master.diagnosis.numerics.arrays import Array
from master.errors import ConfigError, FmuError
from master.fmi.description import Description, Kind, Variable
from master.fmi.slave import Slave
from master.fmi.units import Conversion, conversion
from master.process import position
from master.stepping.compiler import build_program
from master.stepping.failure import failure_of
from master.stepping.initialisation import initialise, read_initial_values
from master.stepping.machine.compiled import compiled
from master.stepping.machine.execution import execute_ticks
from master.stepping.machine.interpreter import Execution, LimitMonitor, Stop, finite_only
from master.stepping.simulate import FATAL, SlaveFactory, load
from master.system.graph import Instance, Port, System, Wire
from master.text.signal_name import SignalName


@dataclass(frozen=True)
class Link:
    """
    One FMU of a chain: what drives its inputs and what is read from it.

    `conversions`: input to what becomes of the value on its wire; that of the units at both ends if none.
    `begins_last`: it follows an FMU that may have no outputs before the end of its initialisation.
    """

    name: str
    description: Description
    measured: Mapping[str, int]
    wired: Mapping[str, str]
    read: tuple[str, ...]
    conversions: Mapping[str, Conversion] = field(default_factory=dict)
    begins_last: bool = False


@dataclass(frozen=True)
class ReplayFailure:
    """
    Why a replay ended early, or gave what is not finite.

    `status` is the name of an FMI status, `row` the first row of the result that is missing or not finite.
    """

    instance: str
    status: str
    message: str
    row: int

    def __str__(self) -> str:
        return f"row {self.row}: {self.message}"


class Player:
    """
    A chain of loaded FMUs; `names` are the signals that a replay gives, `instance.variable`.

    `failure` says what was wrong with the latest replay, None if nothing was.

    Raises:
        FmuError: If one cannot be loaded.
        ConfigError: If a chain reads or drives what is not a number, or its units do not fit.
    """

    def __init__(self, chain: Sequence[Link], factory: SlaveFactory = load) -> None:
        self.chain = list(chain)
        self.names = [f"{link.name}.{variable}" for link in chain for variable in link.read]
        self.failure: ReplayFailure | None = None
        self._factory = factory
        self._system = System(
            {link.name: Instance(link.name, link.description, 1, {}) for link in chain},
            tuple(wire for link in chain for wire in _wires(self.chain, link)),
        )
        self._read = {link.name: [_number(link, name) for name in link.read] for link in chain}
        self._measured = {
            f"{link.name}.{_number(link, name).name}": column
            for link in chain
            for name, column in link.measured.items()
        }
        self._schedule = Schedule.of(
            [method_of(link.name) for link in chain], {link.name: 1 for link in chain}
        )
        self._slaves: dict[str, Slave] = {}
        self._load()

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
        self.failure = None
        try:
            position.current().begin(first * step, step)
            self._initialise(values, data[first], first * step)
        except FmuError as error:
            self._fail(error, 0)
            return out
        memory = self._program.memory
        out[0] = memory.values[self._monitor.record]
        self._program.feed(data[first : first + n + 1])
        rows = np.empty((n, len(self.names)))
        self._monitor.first_beyond[:] = -1
        ended = execute_ticks(compiled(), self._program, self._monitor, first * step, step, 0, n, rows)
        complete = rows[every - 1 : ended.ticks : every]
        out[1 : 1 + len(complete)] = complete
        self._note(ended, first * step + ended.ticks * step, every)
        return out

    def close(self) -> None:
        """Unload the FMUs."""
        failed = self.failure
        for name, slave in self._slaves.items():
            ended = failed is not None and failed.instance == name and failed.status != _NOT_FINITE
            slave.close(failed=ended, fatal=ended and failed is not None and failed.status == FATAL)
        self._slaves = {}

    def _load(self) -> None:
        try:
            for link in self.chain:
                self._slaves[link.name] = self._factory(link.name, link.description)
            self._program = build_program(
                self._system, self._schedule, self._slaves, measured=self._measured, read=self._read
            )
        except BaseException:  # Ctrl-C too: nobody else could unload them
            self.close()
            raise
        places = np.array([self._program.place[name] for name in self.names], dtype=np.int64)
        self._monitor: LimitMonitor = finite_only(places)._replace(used=np.zeros(len(places), dtype=np.int64))
        self._is_fresh = True

    def _initialise(self, values: Mapping[str, Mapping[str, float | str]], row: Array, t0: float) -> None:
        if not self._is_fresh:
            self._reset()
        self._is_fresh = False
        instances = {
            name: replace(instance, start=values.get(name, {}))
            for name, instance in self._system.instances.items()
        }
        system = replace(self._system, instances=instances)
        given = {name: float(row[column]) for name, column in self._measured.items()}
        last = [link.name for link in self.chain if link.begins_last]
        initialise(system, self._schedule, self._slaves, t0, given=given, last=last)
        read_initial_values(system, self._slaves, self._program, self._read)

    def _reset(self) -> None:
        try:
            for slave in self._slaves.values():
                slave.reset()
        except FmuError as error:  # not every FMU can be reset: then it is loaded again
            self.failure = ReplayFailure(error.instance, error.status, str(error), 0)
            self.close()
            self.failure = None
            self._load()

    def _note(self, ended: Execution, time: float, every: int) -> None:
        """Keep why the replay ended, or which signal is not finite."""
        if ended.stop == Stop.FAILED:
            self._fail(failure_of(self._program, self._slaves, ended, time), 1 + ended.ticks // every)
        elif ended.stop == Stop.ASKED_FOR_END:
            name = self._program.instance_of(ended.where)
            error = FmuError(name, "asks for the end of the simulation", time=time)
            self._fail(error, 1 + ended.ticks // every)
        elif (beyond := np.flatnonzero(self._monitor.first_beyond >= 0)).size:
            signal = min(beyond, key=lambda j: self._monitor.first_beyond[j])
            row = 1 + int(self._monitor.first_beyond[signal]) // every
            name = self.names[signal]
            message = f"{name} is not a number or infinite"
            self.failure = ReplayFailure(SignalName(name).instance, _NOT_FINITE, message, row)

    def _fail(self, error: FmuError, row: int) -> None:
        self.failure = ReplayFailure(error.instance, error.status, str(error), row)
        if error.status == FATAL:  # not even a reset is allowed then
            self.close()
            self._load()


_NOT_FINITE = "not finite"


def _wires(chain: Sequence[Link], link: Link) -> list[Wire]:
    """Connections into one FMU of a chain, in one step along it."""
    ports: dict[str, Port] = {}
    for other in chain:
        ports |= {f"{other.name}.{name}": Port(other.name, _number(other, name)) for name in other.read}
    wires = []
    for name, signal in link.wired.items():
        source = ports[signal]
        target = Port(link.name, _number(link, name))
        converted = link.conversions.get(name) or conversion(source.variable.unit, target.variable.unit)
        if converted is None:
            units = f"{source.variable.unit_name} -> {target.variable.unit_name}"
            raise ConfigError([f"{target.name}: units differ, got {units}, expected the same quantity"])
        wires.append(Wire(source, target, 0, converted))
    return wires


def _number(link: Link, name: str) -> Variable:
    variable = link.description.by_name[name]
    if variable.kind is Kind.STRING:
        raise ConfigError([f"{link.name}.{name}: kind, got String, expected a number in a replay"])
    return variable

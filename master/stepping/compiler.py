"""From a schedule to the flat program: which operations, in which order, on which cells."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from master.coupling.schedule import Iteration, Schedule
from master.fmi.description import Kind, Variable, completed
from master.fmi.slave import Slave
from master.stepping.machine.program import (
    BLOCK_WIDTH,
    CHANNEL,
    CHECK,
    COPY,
    COPY_WIDTH,
    EXTRAPOLATE,
    KEEP,
    OPERATION_WIDTH,
    RESTORE,
    SAVE,
    SLAVE_WIDTH,
    STEP,
    Memory,
    Program,
)
from master.system.channel import HELD
from master.system.graph import Port, System, Wire

Channels = Mapping[str, int]
Functions = Mapping[tuple[Kind, int], int]


def build_program(
    system: System, schedule: Schedule, slaves: Mapping[str, Slave], channels: Channels | None = None
) -> Program:
    """
    Translate a schedule into the program of one tick.

    Args:
        system: The graph.
        schedule: Groups and rates.
        slaves: Their interfaces give the addresses.
        channels: Connected inputs under a scenario, with the longest delay [ticks] it may give them.
    """
    return _Translator(system, schedule, slaves, channels or {}).build()


class _Translator:
    def __init__(
        self, system: System, schedule: Schedule, slaves: Mapping[str, Slave], channels: Channels
    ) -> None:
        self.system, self.schedule, self.channels = system, schedule, channels
        self.names = list(system.instances)
        self.interfaces = {name: slaves[name].interface() for name in self.names}
        self.operations: list[list[int]] = []
        self.blocks: list[list[int]] = []
        self.copies: list[list[int]] = []
        self.conversions: list[tuple[float, float]] = []
        self.references: list[NDArray[np.uint32]] = []
        self.loops: list[list[int]] = []
        self.residuals: list[list[int]] = []
        self.tolerances: list[float] = []
        self.loop_wires: list[str] = []
        self.channel_of: dict[str, int] = {}
        self.n_cells = 0
        self.place: dict[str, int] = {}
        self.inputs: dict[str, tuple[int, int]] = {}
        self.outputs: dict[str, tuple[int, int]] = {}

    def build(self) -> Program:
        self._allocate()
        for i, group in enumerate(self.schedule.groups):
            if i in self.schedule.iterations:
                self._iterate(group, self.schedule.iterations[i])
            else:
                self._side_by_side(group)
        return Program(
            memory=self._memory(),
            place=self.place,
            names=self.names,
            loop_wires=self.loop_wires,
            channel_of=self.channel_of,
            keep_alive=self.references,
        )

    def _memory(self) -> Memory:
        return Memory(
            operations=_table(self.operations, OPERATION_WIDTH),
            blocks=_table(self.blocks, BLOCK_WIDTH),
            slaves=_table([self._slave(name) for name in self.names], SLAVE_WIDTH),
            copies=_table(self.copies, COPY_WIDTH),
            conversions=np.array(self.conversions, dtype=np.float64).reshape(-1, 2),
            values=self._start_values(),
            rings=np.zeros(self.n_cells),
            states=np.zeros(len(self.names), dtype=np.int64),
            loops=_table(self.loops, 5),
            residuals=_table(self.residuals, 3),
            tolerances=np.array(self.tolerances, dtype=np.float64),
            channels=np.zeros((len(self.channel_of), HELD + 1)),
        )

    def _slave(self, name: str) -> list[int]:
        interface = self.interfaces[name]
        called = [interface.component, interface.version, interface.do_step]
        return [*called, *self.inputs[name], *self.outputs[name]]

    def _start_values(self) -> NDArray[np.float64]:
        """Elements of an array that no wire sets keep their start value."""
        values = np.zeros(len(self.place))
        for name, instance in self.system.instances.items():
            for v in instance.description.variables:
                if v.element is not None and v.causality == "input" and f"{name}.{v.name}" in self.place:
                    values[self.place[f"{name}.{v.name}"]] = float(instance.value_of(v.name) or 0.0)
        return values

    def _allocate(self) -> None:
        """Outputs first: a row of the result is then read from neighbouring places."""
        for name in self.names:
            outputs = self.system.instances[name].description.outputs
            self.outputs[name] = self._blocks(name, outputs, self.interfaces[name].getters)
        for name in self.names:
            inputs = [w.target.variable for w in self.system.wires_into(name)]
            self.inputs[name] = self._blocks(name, inputs, self.interfaces[name].setters)

    def _blocks(self, instance: str, variables: Sequence[Variable], functions: Functions) -> tuple[int, int]:
        """One block for the scalars of each type and one for each array; the first and the one behind."""
        whole = completed(variables, self.system.instances[instance].description.variables)
        groups: dict[tuple[Kind, int, int | None], list[Variable]] = {}
        for v in whole:
            array = None if v.element is None else v.reference
            groups.setdefault((v.kind, v.value_type, array), []).append(v)
        first = len(self.blocks)
        for (kind, value_type, _), chosen in groups.items():
            self._block(instance, functions[kind, value_type], chosen)
        return first, len(self.blocks)

    def _block(self, instance: str, function: int, chosen: Sequence[Variable]) -> None:
        references = np.array(list(dict.fromkeys(v.reference for v in chosen)), dtype=np.uint32)
        self.references.append(references)
        counts = [len(references), len(chosen)]
        place = len(self.place)
        self.blocks.append([function, references.ctypes.data, *counts, chosen[0].value_type, place])
        for v in chosen:
            self.place[Port(instance, v).name] = len(self.place)

    def _side_by_side(self, group: Sequence[str]) -> None:
        for name in group:
            for wire in self.system.wires_into(name):
                self._transfer(wire)
        for name in group:
            self._step(name)

    def _iterate(self, group: Sequence[str], iteration: Iteration) -> None:
        """Save all members; then restore, step one after the other, and check the wires among them."""
        inner = [w for name in group for w in self.system.wires_into(name) if _is_inner(w, group)]
        for name in group:
            for wire in self.system.wires_into(name):
                if wire not in inner:
                    self._transfer(wire)
        every = self.schedule.every[group[0]]
        for name in group:
            self._add(SAVE, every, self.names.index(name), self.interfaces[name].get_state)
        back = len(self.operations)
        for name in group:
            self._add(RESTORE, every, self.names.index(name), self.interfaces[name].set_state)
        for name in group:
            for wire in inner:
                if wire.target.instance == name:
                    self._transfer(wire)
            self._step(name)
        self._check(inner, iteration, back, every)

    def _check(self, inner: Sequence[Wire], iteration: Iteration, back: int, every: int) -> None:
        first = len(self.residuals)
        for wire in inner:
            source, target = self.place[wire.source.name], self._taken(wire)
            self.residuals.append([source, target, self._conversion(wire)])
            self.tolerances.append(self.schedule.tolerance_of(wire))
            self.loop_wires.append(f"{wire.source.name} -> {wire.target.name}")
        self._add(CHECK, every, len(self.loops))
        self.loops.append([back, first, len(self.residuals), iteration.maximum, 0])

    def _transfer(self, wire: Wire) -> None:
        has_channel = wire.target.name in self.channels
        every = 1 if has_channel else self.schedule.every[wire.target.instance]
        source, target = self.place[wire.source.name], self.place[wire.target.name]
        if wire.delay:
            self._add(KEEP, 1, source, target, self._cells(wire.delay), wire.delay)
            source, every = target, 1
        if not (wire.delay and wire.conversion.is_identity):
            self._copy(every, source, target, self._conversion(wire))
        if has_channel:
            self._copy(every, target, self._taken(wire), self._number((1.0, 0.0)))
            self._channel(wire.target.name, target)
        if wire.extrapolation:
            rate, cells = self.schedule.every[wire.target.instance], self._cells(wire.extrapolation)
            self._add(EXTRAPOLATE, rate, target, wire.extrapolation, cells)

    def _taken(self, wire: Wire) -> int:
        """Where a wire's value stands before its channel changes it: by it an iteration is judged."""
        name = wire.target.name
        return (
            self.place.setdefault(f"{name} before its channel", len(self.place))
            if name in self.channels
            else self.place[name]
        )

    def _copy(self, every: int, source: int, target: int, conversion: int) -> None:
        """Copies that follow each other at the same ticks are one operation."""
        n = len(self.copies)
        self.copies.append([source, target, conversion])
        if self.operations and self.operations[-1][:2] == [COPY, every]:
            self.operations[-1][3] = n + 1
        else:
            self._add(COPY, every, n, n + 1)

    def _channel(self, name: str, target: int) -> None:
        n = self.channels[name] + 1
        self.channel_of[name] = len(self.channel_of)
        self._add(CHANNEL, 1, target, self.channel_of[name], self._cells(n), n)

    def _cells(self, n: int) -> int:
        first = self.n_cells
        self.n_cells += n
        return first

    def _conversion(self, wire: Wire) -> int:
        return self._number((wire.conversion.factor, wire.conversion.offset))

    def _number(self, pair: tuple[float, float]) -> int:
        if pair not in self.conversions:
            self.conversions.append(pair)
        return self.conversions.index(pair)

    def _step(self, instance: str) -> None:
        self._add(STEP, self.schedule.every[instance], self.names.index(instance))

    def _add(self, code: int, every: int, *arguments: int) -> None:
        self.operations.append([code, every, *arguments, *[0] * (4 - len(arguments))])


def _is_inner(wire: Wire, group: Sequence[str]) -> bool:
    return wire.source.instance in group and not wire.delay


def _table(rows: list[list[int]], width: int) -> NDArray[np.int64]:
    return np.array(rows, dtype=np.int64).reshape(-1, width)

"""The schedule as a flat program over one table of values: what `stepping` executes each tick."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from .description import Kind, Variable
from .graph import Port, System, Wire
from .schedule import Schedule
from .slave import Slave

COPY, KEEP, SET, STEP, GET = range(5)

Integers = NDArray[np.int64]
Floats = NDArray[np.float64]


@dataclass
class Program:
    """
    Operations of one tick and the memory they work on.

    `operations` has a row [code, every, a, b, c, d] for each operation:

        COPY  source, target, conversion            values[target] = factor * values[source] + offset
        KEEP  source, target, first cell, n cells   the same through a ring of n ticks, no conversion
        SET   slave, setter, block                  values of the block -> slave
        STEP  slave, do_step                        one step of `every` ticks
        GET   slave, getter, block                  slave -> values of the block

    `blocks` has a row [address of the references, n, first place in values, type] for each block,
    `slaves` a row [component, FMI version] for each slave.
    """

    operations: Integers
    blocks: Integers
    slaves: Integers
    conversions: Floats
    values: Floats
    rings: Floats
    place: dict[str, int]
    names: list[str]
    keep_alive: list[NDArray[np.uint32]] = field(default_factory=list)

    def fill_rings(self) -> None:
        """Let delayed connections hold the present value of their source."""
        for code, _, source, _, first, n in self.operations:
            if code == KEEP:
                self.rings[first : first + n] = self.values[source]

    def instance_of(self, operation: int) -> str:
        """Name the slave that an operation belongs to."""
        return self.names[int(self.operations[operation, 2])]


class _Builder:
    def __init__(self, system: System, schedule: Schedule, slaves: Mapping[str, Slave]) -> None:
        self.system, self.schedule = system, schedule
        self.names = list(system.instances)
        self.interfaces = {name: slaves[name].interface() for name in self.names}
        self.operations: list[list[int]] = []
        self.blocks: list[list[int]] = []
        self.conversions: list[tuple[float, float]] = []
        self.references: list[NDArray[np.uint32]] = []
        self.n_rings = 0
        self.place: dict[str, int] = {}

    def build(self) -> Program:
        setters, getters = self._allocate()
        for group in self.schedule.groups:
            for name in group:
                self._transfers(name)
            for name in group:
                self._step(name, setters[name], getters[name])
        interfaces = [self.interfaces[name] for name in self.names]
        return Program(
            operations=np.array(self.operations, dtype=np.int64).reshape(-1, 6),
            blocks=np.array(self.blocks, dtype=np.int64).reshape(-1, 4),
            slaves=np.array([[i.component, i.version] for i in interfaces], dtype=np.int64),
            conversions=np.array(self.conversions, dtype=np.float64).reshape(-1, 2),
            values=np.zeros(len(self.place)),
            rings=np.zeros(self.n_rings),
            place=self.place,
            names=self.names,
            keep_alive=self.references,
        )

    def _allocate(self) -> tuple[dict[str, list[list[int]]], dict[str, list[list[int]]]]:
        setters: dict[str, list[list[int]]] = {}
        getters: dict[str, list[list[int]]] = {}
        for i, name in enumerate(self.names):
            interface = self.interfaces[name]
            inputs = [w.target.variable for w in self.system.wires_into(name)]
            outputs = self.system.instances[name].description.outputs
            setters[name] = [[i, interface.setters[k, t], b] for k, t, b in self._blocks(name, inputs)]
            getters[name] = [[i, interface.getters[k, t], b] for k, t, b in self._blocks(name, outputs)]
        return setters, getters

    def _blocks(self, instance: str, variables: Sequence[Variable]) -> list[tuple[Kind, int, int]]:
        made = []
        for kind, value_type in dict.fromkeys((v.kind, v.value_type) for v in variables):
            chosen = [v for v in variables if (v.kind, v.value_type) == (kind, value_type)]
            references = np.array([v.reference for v in chosen], dtype=np.uint32)
            self.references.append(references)
            self.blocks.append([references.ctypes.data, len(chosen), len(self.place), value_type])
            for v in chosen:
                self.place[Port(instance, v).name] = len(self.place)
            made.append((kind, value_type, len(self.blocks) - 1))
        return made

    def _transfers(self, instance: str) -> None:
        every = self.schedule.every[instance]
        for wire in self.system.wires_into(instance):
            source, target = self.place[wire.source.name], self.place[wire.target.name]
            if wire.delay:
                self._add(KEEP, 1, source, target, self.n_rings, wire.delay)
                self.n_rings += wire.delay
                source = target
            if not (wire.delay and wire.conversion.is_identity):
                self._add(COPY, 1 if wire.delay else every, source, target, self._conversion(wire))

    def _conversion(self, wire: Wire) -> int:
        pair = (wire.conversion.factor, wire.conversion.offset)
        if pair not in self.conversions:
            self.conversions.append(pair)
        return self.conversions.index(pair)

    def _step(self, instance: str, setters: list[list[int]], getters: list[list[int]]) -> None:
        every = self.schedule.every[instance]
        for setter in setters:
            self._add(SET, every, *setter)
        self._add(STEP, every, self.names.index(instance), self.interfaces[instance].do_step)
        for getter in getters:
            self._add(GET, every, *getter)

    def _add(self, code: int, every: int, *arguments: int) -> None:
        self.operations.append([code, every, *arguments, *[0] * (4 - len(arguments))])


def build_program(system: System, schedule: Schedule, slaves: Mapping[str, Slave]) -> Program:
    """Translate a schedule into the program of one tick."""
    return _Builder(system, schedule, slaves).build()

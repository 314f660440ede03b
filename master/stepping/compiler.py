"""From a schedule to the flat program: which operations, in which order, on which cells."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from master.coupling.methods.method import Residual
from master.coupling.schedule import Schedule
from master.errors import ConfigError
from master.fmi.description import Kind, Variable
from master.fmi.slave import Slave
from master.process import position
from master.stepping.machine.program import (
    ANSWER_CELLS,
    BLOCK_WIDTH,
    CONVERSION_WIDTH,
    COPY_WIDTH,
    FEED_WIDTH,
    LOOP_WIDTH,
    MAP_WIDTH,
    OPERATION_WIDTH,
    RESIDUAL_WIDTH,
    SLAVE_WIDTH,
    BlockRow,
    Memory,
    Operation,
    Program,
)
from master.system.channel import Channel
from master.system.graph import Port, System, Wire

Functions = Mapping[tuple[Kind, int], int]
_IDENTITY = (1.0, 0.0)


def build_program(
    system: System,
    schedule: Schedule,
    slaves: Mapping[str, Slave],
    channels: Mapping[str, int] | None = None,
    measured: Mapping[str, int] | None = None,
    read: Mapping[str, Sequence[Variable]] | None = None,
) -> Program:
    """
    Compile a schedule into the program of one tick.

    Args:
        system: The graph.
        schedule: Groups and rates.
        slaves: Their interfaces give the addresses.
        channels: Connected inputs under a scenario, with the longest delay [ticks] it may give them.
        measured: Inputs that get measured values, with their columns.
        read: What is read from an instance after its step; its outputs if None.
    """
    return _Compiler(system, schedule, slaves, channels or {}, measured or {}, read).build()


class _Compiler:
    """Emits operations for the coupling methods; see `Emitter`."""

    def __init__(
        self,
        system: System,
        schedule: Schedule,
        slaves: Mapping[str, Slave],
        channels: Mapping[str, int],
        measured: Mapping[str, int],
        read: Mapping[str, Sequence[Variable]] | None,
    ) -> None:
        self.system = system
        self.schedule = schedule
        self.channels = channels
        self.measured = measured
        self.outlets = system.outlets if read is None else ()
        outputs = {name: system.read_from(name) for name in system.instances}
        self.read: Mapping[str, Sequence[Variable]] = outputs if read is None else read
        self.number_of = {name: i for i, name in enumerate(system.instances)}
        self.interfaces = {name: slaves[name].interface() for name in system.instances}
        self.wires: dict[str, list[Wire]] = {name: [] for name in system.instances}
        for wire in system.wires:
            self.wires[wire.target.instance].append(wire)
        self.operations: list[list[int]] = []
        self.blocks: list[list[int]] = []
        self.copies: list[list[int]] = []
        self.feeds: list[list[int]] = []
        self.maps: list[tuple[float, float]] = []
        self.conversions: dict[tuple[float, float], int] = {}
        self.references: list[NDArray[np.uint32]] = []
        self.loops: list[list[int]] = []
        self.residuals: list[list[int]] = []
        self.tolerances: list[float] = []
        self.loop_wires: list[str] = []
        self.channel_of: dict[str, int] = {}
        self.n_cells = 0
        self.n_places = 0
        self.placed: dict[str, int] = {}
        self.inputs: dict[str, tuple[int, int]] = {}
        self.outputs: dict[str, tuple[int, int]] = {}

    def build(self) -> Program:
        """Emit all groups."""
        faults = self.schedule.event_faults(self.system, self.channels)
        if faults:
            raise ConfigError([f"events: {fault}" for fault in faults])
        self._allocate()
        for group in self.schedule.groups:
            group.emit(self, self.schedule.every)
        for wire in self.outlets:
            self._let_out(wire)
        return Program(
            memory=self._memory(),
            place=self.placed,
            slaves=[(name, interface.version) for name, interface in self.interfaces.items()],
            loop_wires=self.loop_wires,
            channel_of=self.channel_of,
            keep_alive=self.references,
        )

    def wires_into(self, instance: str) -> Sequence[Wire]:
        """Connections of all inputs of an instance."""
        return self.wires[instance]

    def transfer(self, wire: Wire, every: int) -> None:
        """Bring a connection's value to the input: its delay, conversion, fault and extrapolation."""
        has_channel = wire.target.name in self.channels
        rate = every
        every = 1 if has_channel else every
        source, target = self.source(wire), self.place(wire.target.name)
        if wire.delay:
            self._add(Operation.KEEP, 1, source, target, self._cells(wire.delay), wire.delay)
            source = target
            every = 1
        self._convert(wire, source, target, every)
        if has_channel:
            self.copy(target, self.arrived(wire), every)
            self._channel(wire.target.name, target)
        if wire.extrapolation:
            cells = self._cells(wire.extrapolation)
            self._add(Operation.EXTRAPOLATE, rate, target, wire.extrapolation, cells)

    def _convert(self, wire: Wire, source: int, target: int, every: int) -> None:
        if not wire.conversion.is_affine:
            self._add(Operation.MAP, every, source, target, len(self.maps), len(wire.conversion.table))
            self.maps += wire.conversion.table
            source = target
        if source != target or wire.conversion.is_scaled:
            self.copy(source, target, every, wire)

    def _let_out(self, wire: Wire) -> None:
        """Let an output of the whole system have the value of its source after each tick."""
        name = wire.target.name
        source = self.placed.get(wire.source.name)
        if source is not None and wire.conversion.is_identity:
            self.placed[name] = source
            return
        target = self.places(name, 1)
        if source is None:  # an input of the system: from a recording, or held until an event
            if name in self.measured:
                self.feeds.append([target, self.measured[name]])
                self._add(Operation.FEED, 1, len(self.feeds) - 1, len(self.feeds))
            return
        self._convert(wire, source, target, 1)

    def feed(self, instance: str, every: int) -> Mapping[str, int]:
        """Copy measured values to the inputs that have any; give these and their places."""
        own = {name: c for name, c in self.measured.items() if name.partition(".")[0] == instance}
        if own:
            first = len(self.feeds)
            self.feeds += [[self.place(name), column] for name, column in own.items()]
            self._add(Operation.FEED, every, first, len(self.feeds))
        return {name: self.place(name) for name in own}

    def step(self, instance: str, every: int, back: int | None = None, length: int | None = None) -> None:
        """Step from `back` ticks before the end of the tick over `length` ticks; `every` if None."""
        back = every if back is None else back
        self._add(Operation.STEP, every, self.number_of[instance], back, every if length is None else length)

    def save(self, instance: str, every: int) -> None:
        """Save the state of an instance."""
        self._add(Operation.SAVE, every, self.number_of[instance], self.interfaces[instance].get_state)

    def restore(self, instance: str, every: int) -> None:
        """Put the saved state back."""
        self._add(Operation.RESTORE, every, self.number_of[instance], self.interfaces[instance].set_state)

    def collect(self, source: int, first: int, n: int) -> None:
        """Write a value each tick to the next of n places, round and round."""
        self._add(Operation.COLLECT, 1, source, first, n)

    def copy(self, source: int, target: int, every: int, wire: Wire | None = None) -> None:
        """Copy from place to place, converted as on a wire; those in a row at the same ticks become one."""
        n = len(self.copies)
        self.copies.append([source, target, self._conversion(wire)])
        if self.operations and self.operations[-1][:2] == [Operation.COPY, every]:
            self.operations[-1][3] = n + 1
        else:
            self._add(Operation.COPY, every, n, n + 1)

    def here(self) -> int:
        """Place of the next operation."""
        return len(self.operations)

    def check(self, residuals: Sequence[Residual], maximum: int, back: int, every: int) -> None:
        """Go back to an operation until all residuals are within tolerance, at most `maximum` passes."""
        first = len(self.residuals)
        for source, target, wire in residuals:
            self.residuals.append([source, target, self._conversion(wire)])
            self.tolerances.append(self.schedule.tolerance_of(wire))
            self.loop_wires.append(f"{wire.source.name} -> {wire.target.name}")
        self._add(Operation.CHECK, every, len(self.loops))
        self.loops.append([back, first, len(self.residuals), maximum, 0])

    def source(self, wire: Wire) -> int:
        """Place of the output that a wire starts from."""
        return self.place(wire.source.name)

    def place(self, signal: str) -> int:
        """Place of a signal."""
        return self.placed[signal]

    def arrived(self, wire: Wire) -> int:
        """Place of a wire's value before a fault of a scenario changes it: an iteration is judged by it."""
        name = wire.target.name
        if name not in self.channels:
            return self.place(name)
        before = f"{name} before its channel"
        return self.placed[before] if before in self.placed else self.places(before, 1)

    def places(self, name: str, n: int) -> int:
        """Reserve n places in a row in the table of values and return the first."""
        first = self.n_places
        self.placed[name] = first
        self.n_places += n
        return first

    def _memory(self) -> Memory:
        return Memory(
            operations=_table(self.operations, OPERATION_WIDTH),
            blocks=_table(self.blocks, BLOCK_WIDTH),
            slaves=_table([self._slave(name) for name in self.system.instances], SLAVE_WIDTH),
            copies=_table(self.copies, COPY_WIDTH),
            conversions=np.array(list(self.conversions), dtype=np.float64).reshape(-1, CONVERSION_WIDTH),
            maps=np.array(self.maps, dtype=np.float64).reshape(-1, MAP_WIDTH),
            feeds=_table(self.feeds, FEED_WIDTH),
            measured=np.zeros((0, max(self.measured.values(), default=-1) + 1)),
            values=np.zeros(self.n_places),
            scratch=np.zeros(ANSWER_CELLS + self.n_places),
            rings=np.zeros(self.n_cells),
            states=np.zeros(len(self.system.instances), dtype=np.int64),
            loops=_table(self.loops, LOOP_WIDTH),
            residuals=_table(self.residuals, RESIDUAL_WIDTH),
            tolerances=np.array(self.tolerances, dtype=np.float64),
            channels=np.zeros((len(self.channel_of), len(Channel))),
            position=np.asarray(position.current().cells),
        )

    def _slave(self, name: str) -> list[int]:
        interface = self.interfaces[name]
        called = [interface.component, interface.version, interface.do_step]
        may_change_float_mode = not self.system.instances[name].description.keeps_float_mode
        return [*called, *self.inputs[name], *self.outputs[name], may_change_float_mode]

    def _allocate(self) -> None:
        """Outputs first: a row of the result is then read from neighbouring places."""
        for name in self.system.instances:
            self.outputs[name] = self._blocks(name, self.read[name], self.interfaces[name].getters)
        for name, instance in self.system.instances.items():
            inputs = [
                instance.description.by_name[signal.partition(".")[2]]
                for signal in self.measured
                if signal.partition(".")[0] == name
            ]
            inputs += [w.target.variable for w in self.wires[name]]
            self.inputs[name] = self._blocks(name, inputs, self.interfaces[name].setters)

    def _blocks(self, instance: str, variables: Sequence[Variable], functions: Functions) -> tuple[int, int]:
        """One block for the scalars of each type and one for each array; the first and the one after."""
        groups: dict[tuple[Kind, int, str | None], list[Variable]] = {}
        for v in _completed(variables, self.system.instances[instance].description.arrays):
            groups.setdefault((v.kind, v.value_type, v.array), []).append(v)
        first = len(self.blocks)
        for (kind, value_type, _), chosen in groups.items():
            self._block(instance, functions[kind, value_type], chosen)
        return first, len(self.blocks)

    def _block(self, instance: str, function: int, chosen: Sequence[Variable]) -> None:
        """One call: the elements of an array, or scalars, of which aliases share a reference and a place."""
        is_array = chosen[0].array is not None
        references = np.array(list(dict.fromkeys(v.reference for v in chosen)), dtype=np.uint32)
        self.references.append(references)
        n_values = len(chosen) if is_array else len(references)
        block = BlockRow(
            function=function,
            references=references.ctypes.data,
            n=len(references),
            n_values=n_values,
            value_type=chosen[0].value_type,
            place=self.n_places,
        )
        self.blocks.append(list(block))
        first_of: dict[int, int] = {}
        for v in chosen:
            key = len(first_of) if is_array else v.reference
            name = Port(instance, v).name
            if key in first_of:
                self.placed[name] = first_of[key]
            else:
                first_of[key] = self.places(name, 1)

    def _channel(self, name: str, target: int) -> None:
        n = self.channels[name] + 1
        self.channel_of[name] = len(self.channel_of)
        self._add(Operation.CHANNEL, 1, target, self.channel_of[name], self._cells(n), n)

    def _cells(self, n: int) -> int:
        first = self.n_cells
        self.n_cells += n
        return first

    def _conversion(self, wire: Wire | None) -> int:
        pair = _IDENTITY if wire is None else (wire.conversion.factor, wire.conversion.offset)
        return self.conversions.setdefault(pair, len(self.conversions))

    def _add(self, code: Operation, every: int, *arguments: int) -> None:
        self.operations.append([int(code), every, *arguments, *[0] * (4 - len(arguments))])


def _completed(variables: Sequence[Variable], arrays: Mapping[str, Sequence[Variable]]) -> list[Variable]:
    """Complete the arrays of which a list has elements, in the order of the array."""
    named = dict.fromkeys(v.array for v in variables if v.array is not None)
    return [v for v in variables if v.array is None] + [v for name in named for v in arrays[name]]


def _table(rows: list[list[int]], width: int) -> NDArray[np.int64]:
    return np.array(rows, dtype=np.int64).reshape(-1, width)

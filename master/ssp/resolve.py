"""From a structure to FMUs, wires between them and the values they start from: nesting is flattened here."""

from __future__ import annotations

import re
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path as FilePath

from master.errors import ConfigError
from master.fmi.structure import with_structure
from master.fmi.units import Conversion, conversion

from .carry import carry
from .network import (
    Edge,
    Leaf,
    Network,
    Path,
    Point,
    make_network,
    shape_fault,
    shape_of,
    sinks,
    type_of,
    variable_of,
)
from .parameters import Assignments, Bound, assign, through
from .structure import INPUTS, OUTPUTS, Connector, DataType, Recording, Structure

SEPARATOR = "/"  # between a system and what is in it
_FORBIDDEN = re.compile(r"[\s.<>/]")


@dataclass(frozen=True)
class ResolvedFmu:
    """An FMU with the values that it starts from and where each was given."""

    file: FilePath
    start: Mapping[str, float | int | bool | str]
    where: str
    places: Mapping[str, str]


@dataclass(frozen=True)
class ResolvedWire:
    """
    A connection between two FMUs.

    `conversion` is None where it is what the units of the two variables ask for.
    """

    source: str
    target: str
    conversion: Conversion | None
    where: str


@dataclass(frozen=True)
class ResolvedConnector:
    """A connector of the system or a recording: `type` is that of its other end where it has none."""

    kind: str
    type: DataType
    shape: tuple[int, ...]
    start: float | int | bool | str | None
    where: str


@dataclass(frozen=True)
class Resolved:
    """
    A flat system.

    `connectors` are those of the outermost system and of recordings that lead somewhere, by
    `owner.connector`; `recordings` are by their owner. `notes` says what a user should know of how it was
    read.
    """

    fmus: Mapping[str, ResolvedFmu]
    wires: tuple[ResolvedWire, ...]
    connectors: Mapping[str, ResolvedConnector]
    recordings: Mapping[str, Recording]
    notes: tuple[str, ...]


def resolve(structure: Structure, trusted: Collection[tuple[str, str]] = ()) -> Resolved:
    """
    Flatten a structure.

    Args:
        structure: As read.
        trusted: Connections (source, target) whose types may differ, as this project's export wrote them.

    Raises:
        ConfigError: With every fault.
    """
    network = make_network(structure.system)
    assigned = assign(network, structure.system)
    problems = network.problems + assigned.problems
    problems += _give_structures(network, assigned)
    if not network.leaves:
        problems.append(f"{structure.system.where}: nothing to step, got no component, expected an FMU")
    if problems:
        raise ConfigError(dict.fromkeys(problems))
    return _Flat(structure, network, assigned, frozenset(trusted)).resolved()


def _give_structures(network: Network, assigned: Assignments) -> list[str]:
    """Resize arrays as structural parameters say; return faults of connectors' shapes."""
    problems: list[str] = []
    for path, leaf in list(network.leaves.items()):
        own = {p.connector: b for p, b in assigned.values.items() if p.owner == path}
        try:
            fmu = with_structure(leaf.component.fmu, {name: bound.values[0] for name, bound in own.items()})
        except ConfigError as error:
            where = next((bound.where for bound in own.values()), leaf.component.where)
            problems += [f"{where}: {p}".replace(f"{leaf.component.file}: ", "") for p in error.problems]
            continue
        network.leaves[path] = replace(leaf, component=replace(leaf.component, fmu=fmu))
        for connector in leaf.component.connectors.values():
            if variable_of(fmu, connector.name) is not None:
                fault = shape_fault(connector, shape_of(fmu, connector.name), f"of {fmu.model_name}")
                problems += [] if fault is None else [fault]
    return problems


class _Flat:
    def __init__(
        self,
        structure: Structure,
        network: Network,
        assigned: Assignments,
        trusted: Collection[tuple[str, str]],
    ) -> None:
        self.structure = structure
        self.network = network
        self.assigned = assigned
        self.trusted = trusted
        self.names = _names([*network.leaves, *network.recordings])
        self.problems: list[str] = []
        self.notes = list(assigned.notes)
        self.wires: list[ResolvedWire] = []
        self.starts: dict[Path, dict[str, Bound]] = {path: {} for path in network.leaves}
        self.owner = _owner(structure.system.name, self.names.values())
        self.connectors: dict[str, ResolvedConnector] = {}

    def resolved(self) -> Resolved:
        for point, bound in self.assigned.values.items():
            if point.owner in self.starts:
                self.starts[point.owner][point.connector] = bound
        self._set_outputs()
        for leaf, _, point in sinks(self.network):
            self._feed(leaf, point)
        for connector in self.network.roots.values():
            if connector.kind not in INPUTS:
                self._let_out(connector)
        self._order_wires()
        self._note_unused_recordings()
        fmus = {self.names[path]: self._fmu(path, leaf) for path, leaf in self.network.leaves.items()}
        problems = [*self.problems, *self.network.problems]  # following a path may find a circle
        if problems:
            raise ConfigError(dict.fromkeys(problems))
        renamed = [
            f"{'.'.join(path)!r} is called {name!r} here"
            for path, name in self.names.items()
            if name != SEPARATOR.join(path)
        ]
        if self.connectors and self.owner != self.structure.system.name:
            renamed.append(f"the system {self.structure.system.name!r} is called {self.owner!r} in signals")
        notes = (*self.notes, *renamed)
        recordings = {self.names[path]: one for path, one in self.network.recordings.items()}
        return Resolved(fmus, tuple(self.wires), self.connectors, recordings, notes)

    def _feed(self, leaf: Leaf, point: Point) -> None:
        """Wire an input to the output that it comes from, or start it from the connector's value."""
        path = self.network.source_of(point)
        if not path:
            return
        origin = path[0].source
        for passed in (edge.target for edge in path):
            if passed in self.assigned.values and (
                origin.owner in self.names or origin in self.assigned.values  # FMUs and recordings
            ):
                self._say_overridden(passed, origin)
        try:
            if origin.owner not in self.network.leaves:
                self._hand_in(leaf, point, path)
            if origin.owner in self.network.recordings:
                self.starts[leaf.path].pop(point.connector, None)
            elif origin.owner in self.network.leaves:
                self._wire(leaf, point, path)
            elif origin in self.assigned.values:
                self._start(leaf, point, path)
            else:
                self._start_on_the_way(leaf, point, path)
        except ValueError as error:
            self.problems.append(str(error))

    def _wire(self, leaf: Leaf, point: Point, path: Sequence[Edge]) -> None:
        origin = path[0].source
        source = f"{self.names[origin.owner]}.{origin.connector}"
        target = f"{self.names[leaf.path]}.{point.connector}"
        where = _where(path)
        carried = carry(self.network, path, trusted=(source, target) in self.trusted)
        given, taken = self.network.kinds[origin], self.network.kinds[point]
        if given != "output" or taken != "input":
            raise ValueError(
                f"{where}: cannot be carried, got {given} -> {taken}, expected an output and an input"
            )
        self.starts[leaf.path].pop(point.connector, None)
        variables = (
            variable_of(self.network.leaves[origin.owner].component.fmu, origin.connector),
            variable_of(leaf.component.fmu, point.connector),
        )
        units = [None if v is None else v.unit for v in variables]
        usual = carried.conversion == conversion(*units)
        self.wires.append(ResolvedWire(source, target, None if usual else carried.conversion, where))

    def _hand_in(self, leaf: Leaf, point: Point, path: Sequence[Edge]) -> None:
        """Let a recording, or an input or a parameter of the outermost system, lead to an FMU."""
        connector = self._connector(path[0].source)
        if connector is None or connector.kind == "structuralParameter":
            return
        source = self._signal(path[0].source)
        target = f"{self.names[leaf.path]}.{point.connector}"
        carried = carry(self.network, path, trusted=(source, target) in self.trusted)
        variable = variable_of(leaf.component.fmu, point.connector)
        end = connector.type or (None if variable is None else type_of(variable))
        shape = shape_of(leaf.component.fmu, point.connector)
        self._refuse_other_shape(connector, shape, target)
        self._place(source, connector, end, shape)
        self.wires.append(ResolvedWire(source, target, carried.conversion, _where(path)))

    def _connector(self, point: Point) -> Connector | None:
        """Find a connector of the outermost system or of a recording."""
        if not point.owner:
            return self.network.roots[point.connector]
        recording = self.network.recordings.get(point.owner)
        return None if recording is None else recording.connectors[point.connector]

    def _refuse_other_shape(self, connector: Connector, shape: tuple[int, ...], other: str) -> None:
        fault = shape_fault(connector, shape, f"of {other}")
        self.problems += [] if fault is None else [fault]

    def _signal(self, point: Point) -> str:
        return f"{self.names[point.owner] if point.owner else self.owner}.{point.connector}"

    def _note_unused_recordings(self) -> None:
        used = {wire.source.partition(".")[0] for wire in self.wires}
        for path, recording in self.network.recordings.items():
            if self.names[path] not in used:
                self.notes.append(f"{recording.where}: leads to no FMU and so is not read")

    def _let_out(self, connector: Connector) -> None:
        """Let an output of the outermost system have the value of what leads to it."""
        point = Point((), connector.name)
        path = self.network.source_of(point)
        if not path:
            self.notes.append(f"{connector.where}: is connected to nothing and so is no column of the result")
            return
        origin = path[0].source
        target = f"{self.owner}.{connector.name}"
        leaf = self.network.leaves.get(origin.owner)
        if leaf is None and self._connector(origin) is None:
            self.notes.append(f"{connector.where}: comes from no FMU and so is no column of the result")
            return
        source = self._signal(origin)
        try:
            carried = carry(self.network, path, trusted=(source, target) in self.trusted)
        except ValueError as error:
            self.problems.append(str(error))
            return
        if carried.kind in ("Binary", "Clock"):
            got = f"got {carried.kind} -> {target}"
            self.problems.append(f"{_where(path)}: cannot be exchanged, {got}, expected numbers or truths")
            return
        if carried.kind == "String":
            self.notes.append(f"{connector.where}: is a text and so no column of the result")
            return
        end = self.network.types[origin]
        shape: tuple[int, ...] = ()
        if leaf is None:
            given = self._connector(origin)
            assert given is not None
            self._place(source, given, end or connector.type, (), self._held(origin))
        else:
            variable = variable_of(leaf.component.fmu, origin.connector)
            end = connector.type or (
                None if variable is None else replace(type_of(variable), unit=carried.unit)
            )
            shape = shape_of(leaf.component.fmu, origin.connector)
            self._refuse_other_shape(connector, shape, source)
        self._place(target, connector, end, shape)
        self.wires.append(ResolvedWire(source, target, carried.conversion, _where(path)))

    def _held(self, origin: Point) -> float | int | bool | str | None:
        """Value of an input of the outermost system that leads to an output of it."""
        bound = self.assigned.values.get(origin)
        return None if bound is None else bound.values[0]

    def _place(
        self,
        name: str,
        connector: Connector,
        data_type: DataType | None,
        shape: tuple[int, ...],
        start: float | int | bool | str | None = None,
    ) -> None:
        is_recording = name.partition(".")[0] != self.owner
        kind = "input" if is_recording else connector.kind if connector.kind in INPUTS else "output"
        known = self.connectors.get(name)
        start = start if known is None or known.start is None else known.start
        self.connectors[name] = ResolvedConnector(
            kind, data_type or DataType("Real"), shape, start, connector.where
        )

    def _start(self, leaf: Leaf, point: Point, path: Sequence[Edge]) -> None:
        """Start an input or a parameter from the value of the connector that it comes from."""
        bound = self.assigned.values[path[0].source]
        carried = carry(self.network, path, bound.type)
        try:
            values = through(bound.values, carried)
        except ValueError as error:
            raise ValueError(f"{path[-1].where}: {error}") from None
        self.starts[leaf.path][point.connector] = Bound(values, carried, bound.where)

    def _start_on_the_way(self, leaf: Leaf, point: Point, path: Sequence[Edge]) -> None:
        """The connector at the path's begin has no value: the nearest to it that has one counts."""
        carry(self.network, path)
        for i, edge in enumerate(path[:-1]):
            if edge.target in self.assigned.values:
                self._start(leaf, point, path[i + 1 :])
                return

    def _set_outputs(self) -> None:
        """A value for a system's output is one for the variable behind it."""
        for point, bound in self.assigned.values.items():
            if point.owner in self.starts or self.network.kinds[point] not in OUTPUTS:
                continue
            path = self.network.source_of(point)
            origin = path[0].source if path else point
            if origin.owner not in self.starts:  # no FMU
                self.notes.append(
                    f"{bound.where}: {point} is an output of no FMU, and so the value is not used"
                )
                continue
            try:
                carried = carry(self.network, path)
            except ValueError as error:
                self.problems.append(str(error))
                continue
            if not carried.conversion.is_identity:
                fault = f"{point} is an output that is converted, expected the value on {origin} itself"
                self.problems.append(f"{bound.where}: {fault}")
            self.starts[origin.owner].setdefault(origin.connector, bound)

    def _say_overridden(self, point: Point, origin: Point) -> None:
        where = self.assigned.values[point].where
        self.notes.append(f"{where}: {point} is connected and takes the value of {origin} from the start on")

    def _fmu(self, path: Path, leaf: Leaf) -> ResolvedFmu:
        start: dict[str, float | int | bool | str] = {}
        places: dict[str, str] = {}
        for key, bound in self.starts[path].items():
            elements = leaf.component.fmu.arrays.get(key)
            names = [key] if elements is None else [v.name for v in elements]
            if len(names) != len(bound.values):
                got = f"got {len(bound.values)} values, expected {len(names)}"
                self.problems.append(f"{bound.where}: {key} of {'.'.join(path)}: {got}")
                continue
            for name, value in zip(names, bound.values, strict=True):
                start[name] = value
                places[name] = bound.where
        return ResolvedFmu(leaf.component.file, start, leaf.component.where, places)

    def _order_wires(self) -> None:
        """Keep the order of the file where the system is flat."""
        places = {link.where: i for i, link in enumerate(self.structure.system.links)}
        self.wires.sort(key=lambda wire: places.get(wire.where, len(places)))


def _where(path: Sequence[Edge]) -> str:
    return path[-1].where if len(path) == 1 else f"{path[0].where} ... {path[-1].where}"


def _owner(name: str, taken: Collection[str]) -> str:
    """Name of the system in signals: without what names of FMUs may not have, and none of those."""
    printable = "".join(c if c.isprintable() else "-" for c in name)
    wanted = _FORBIDDEN.sub("-", printable) or "system"
    found = wanted
    n = 2
    while found in taken:
        found = f"{wanted}-{n}"
        n += 1
    return found


def _names(leaves: Collection[Path]) -> dict[Path, str]:
    """Names without what the YAML form forbids, each once."""
    found: dict[Path, str] = {}
    taken: set[str] = set()
    flat = all(len(path) == 1 for path in leaves)
    for path in leaves:
        forbidden = re.compile(r"[\s.<>]") if flat else _FORBIDDEN
        printable = ("".join(c if c.isprintable() else "-" for c in part) for part in path)
        wanted = SEPARATOR.join(forbidden.sub("-", part) for part in printable)
        name = wanted
        n = 2
        while name in taken:
            name = f"{wanted}-{n}"
            n += 1
        taken.add(name)
        found[path] = name
    return found

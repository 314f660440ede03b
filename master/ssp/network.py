"""The connections of all systems as one directed network of connectors, checked against the FMUs."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace

from master.errors import expected
from master.fmi.description import Description, Kind, Variable
from master.fmi.units import Unit

from .structure import (
    INPUTS,
    Component,
    Connector,
    DataType,
    Dictionary,
    End,
    Link,
    Recording,
    Reference,
    SubSystem,
    Transformation,
)

Path = tuple[str, ...]


@dataclass(frozen=True)
class Point:
    """
    A connector by the path of its owner from the outermost system, which has the empty path.

    A dictionary's reference has two for each connector, `side` in and out, and several references share the
    one point of an entry, `side` dictionary.
    """

    owner: Path
    connector: str
    side: str = ""

    def __str__(self) -> str:
        return ".".join((*self.owner, self.connector))


@dataclass(frozen=True)
class Edge:
    """A connection in the direction of its data."""

    source: Point
    target: Point
    converts_units: bool
    transformation: Transformation | None
    where: str


@dataclass(frozen=True)
class Leaf:
    """A component and its path."""

    path: Path
    component: Component


@dataclass
class Network:
    """All components and connectors; `types` is None where a connector has no type of its own."""

    leaves: dict[Path, Leaf] = field(default_factory=dict)
    types: dict[Point, DataType | None] = field(default_factory=dict)
    kinds: dict[Point, str] = field(default_factory=dict)
    into: dict[Point, list[Edge]] = field(default_factory=dict)
    roots: dict[str, Connector] = field(default_factory=dict)
    recordings: dict[Path, Recording] = field(default_factory=dict)
    problems: list[str] = field(default_factory=list)

    def source_of(self, point: Point) -> list[Edge]:
        """Give the edges that lead to a point from where its data comes, that one first."""
        path: list[Edge] = []
        seen = {point}
        while edges := self.into.get(point, []):
            path.insert(0, edges[0])
            point = edges[0].source
            if point in seen:
                self.problems.append(f"{edges[0].where}: leads in a circle, expected a source")
                return []
            seen.add(point)
        return path


@dataclass(frozen=True)
class _Room:
    """A system on the way down: its path, and the dictionaries that are seen from it with their owners."""

    system: SubSystem
    path: Path
    dictionaries: Mapping[str, tuple[Path, Dictionary]]


def make_network(system: SubSystem) -> Network:
    """Join all; faults are left in `problems`."""
    network = Network(roots=dict(system.connectors))
    _enter(network, system, (), {})
    for edges in list(network.into.values()):
        _refuse_second_sources(network, edges)
    return network


def _enter(
    network: Network, system: SubSystem, path: Path, outer: Mapping[str, tuple[Path, Dictionary]]
) -> None:
    room = _Room(system, path, {**outer, **{name: (path, d) for name, d in system.dictionaries.items()}})
    for connector in system.connectors.values():
        if connector.kind == "inout":
            network.problems.append(
                f"{connector.where}: kind inout is for dictionaries, expected a direction"
            )
        _place(network, Point(path, connector.name), connector.kind, connector.type)
    for name, element in system.elements.items():
        inner = (*path, name)
        if isinstance(element, SubSystem):
            _enter(network, element, inner, room.dictionaries)
        elif isinstance(element, Component):
            _enter_component(network, element, inner)
        elif isinstance(element, Recording):
            network.recordings[inner] = element
            for connector in element.connectors.values():
                _place(network, Point(inner, connector.name), "output", connector.type or DataType("Real"))
    for link in system.links:
        _join(network, room, link)
    for element in system.elements.values():
        if isinstance(element, Reference):
            _enter_reference(network, room, element)


def _place(network: Network, point: Point, kind: str, data_type: DataType | None) -> None:
    network.types[point] = data_type
    network.kinds[point] = kind


def _enter_component(network: Network, component: Component, path: Path) -> None:
    network.leaves[path] = Leaf(path, component)
    for connector in component.connectors.values():
        data_type = _component_type(network, component, connector)
        _place(network, Point(path, connector.name), connector.kind, data_type)


def variable_of(fmu: Description, name: str) -> Variable | None:
    """Find a variable by name; for an array its first element."""
    return fmu.by_name.get(name) or next(iter(fmu.arrays.get(name, ())), None)


def shape_of(fmu: Description, name: str) -> tuple[int, ...]:
    """Lengths of an array along each dimension; empty for a scalar."""
    elements = fmu.arrays.get(name, ())
    return tuple(map(int, elements[-1].name.rpartition("[")[2][:-1].split(","))) if elements else ()


def shape_fault(connector: Connector, shape: tuple[int, ...], whose: str) -> str | None:
    """Say which dimensions a connector declares that what it belongs or leads to does not have."""
    declared = connector.shape
    if not declared:
        return None
    if len(declared) != len(shape) or any(a not in (None, b) for a, b in zip(declared, shape, strict=True)):
        got, wanted = (
            " x ".join("?" if n is None else str(n) for n in one) or "a scalar" for one in (declared, shape)
        )
        return f"{connector.where}: shape differs from that {whose}, got {got}, expected {wanted}"
    return None


def type_of(variable: Variable, connector: Connector | None = None) -> DataType:
    """Type of an FMU's variable; a unit that it lacks is that of its connector."""
    kind = "Enumeration" if variable.items else variable.kind.value
    unit = variable.unit
    given = None if connector is None or connector.type is None else connector.type.unit
    if unit is None or (not unit.defined and given is not None and given.name == unit.name):
        unit = given
    items = variable.items or ({} if connector is None or connector.type is None else connector.type.items)
    return DataType(kind, unit, items)


def _component_type(network: Network, component: Component, connector: Connector) -> DataType | None:
    """Type of a component's connector: that of the FMU's variable, which it must not contradict."""
    name, fmu, declared = connector.name, component.fmu, connector.type
    variable = variable_of(fmu, name)
    if variable is None:
        if name not in fmu.not_exchanged and (declared is None or declared.kind not in ("Binary", "Clock")):
            names = expected(name, [v.name for v in fmu.variables])
            network.problems.append(f"{connector.where}: no such variable in {fmu.model_name}, {names}")
        is_clock = "clock" in fmu.not_exchanged.get(name, "")
        return replace(declared or DataType("Binary"), kind="Clock" if is_clock else "Binary")
    causality = "constant" if variable.variability == "constant" else variable.causality
    if connector.kind not in (causality, variable.causality):
        network.problems.append(
            f"{connector.where}: kind differs from the FMU's, got {connector.kind}, expected {causality}"
        )
    found = type_of(variable, connector)
    if declared is None:
        return found
    if not _fits(declared, variable):
        network.problems.append(
            f"{connector.where}: type differs from the FMU's, got {declared.kind}, expected {found.kind}"
        )
    if not _same_unit(declared.unit, variable.unit):
        got = declared.unit.name if declared.unit else ""
        network.problems.append(
            f"{connector.where}: unit differs from the FMU's, got {got!r}, expected {variable.unit_name!r}"
        )
    return found


_KIND_OF = {
    "Real": Kind.REAL,
    "Integer": Kind.INTEGER,
    "Boolean": Kind.BOOLEAN,
    "String": Kind.STRING,
    "Enumeration": Kind.INTEGER,
}


def _fits(declared: DataType, variable: Variable) -> bool:
    return _KIND_OF.get(declared.kind) is variable.kind


def _same_unit(declared: Unit | None, own: Unit | None) -> bool:
    """Whether a connector's unit is the variable's; a difference of temperatures has no offset."""
    if declared is None or own is None:
        return True
    if not (declared.defined and own.defined):
        return declared.name == own.name
    if declared.exponents != own.exponents or declared.factor != own.factor:
        return False
    return declared.offset == own.offset or declared.name == own.name


@dataclass(frozen=True)
class _Side:
    """One end of a connection: whether data may come out of it, whether it may go in, and at which point."""

    gives: Point | None
    takes: Point | None
    kind: str


def _join(network: Network, room: _Room, link: Link) -> None:
    start, end = (_side(network, room, link, side) for side in (link.start, link.end))
    if start is None or end is None:
        return
    if start.gives is not None and end.takes is not None and not (start.takes and end.gives):
        source, target = start.gives, end.takes
    elif end.gives is not None and start.takes is not None and not (end.takes and start.gives):
        source, target = end.gives, start.takes
    else:
        got = f"got {start.kind} and {end.kind}"
        network.problems.append(
            f"{link.where}: no direction, {got}, expected one that gives and one that takes"
        )
        return
    if not _may_follow(network, source, target):
        network.problems.append(
            f"{link.where}: not allowed, got {network.kinds[source]} -> {network.kinds[target]}, "
            "expected a parameter for a parameter, an output for an input"
        )
        return
    edge = Edge(source, target, link.converts_units, link.transformation, link.where)
    network.into.setdefault(target, []).append(edge)


def _side(network: Network, room: _Room, link: Link, end: End) -> _Side | None:
    if end.element is None:
        connectors: Mapping[str, Connector] = room.system.connectors
        owner, element = room.path, None
    elif end.element in room.system.elements:
        element = room.system.elements[end.element]
        connectors, owner = element.connectors, (*room.path, end.element)
    else:
        known = expected(end.element, room.system.elements)
        network.problems.append(f"{link.where}: no such element, got {end.element!r}, {known}")
        return None
    if end.connector not in connectors:
        of = "the system" if end.element is None else repr(end.element)
        known = expected(end.connector, connectors)
        network.problems.append(f"{link.where}: no such connector of {of}, got {end.connector!r}, {known}")
        return None
    kind = connectors[end.connector].kind
    if isinstance(element, Reference):
        into, out = (Point(owner, end.connector, side) for side in ("in", "out"))
        network.kinds[into] = network.kinds[out] = kind
        return _Side(None if kind in INPUTS else out, into if kind in (*INPUTS, "inout") else None, kind)
    point = Point(owner, end.connector)
    gives = (kind in INPUTS) == (end.element is None)
    return _Side(point if gives else None, None if gives else point, kind)


_LEVELS = {"structuralParameter": 0, "constant": 0, "parameter": 1, "calculatedParameter": 1}


def _may_follow(network: Network, source: Point, target: Point) -> bool:
    """Whether the target's value may change as often as the source's; dictionaries take any."""
    first, second = network.kinds[source], network.kinds[target]
    return "inout" in (first, second) or _LEVELS.get(first, 2) <= _LEVELS.get(second, 2)


def _enter_reference(network: Network, room: _Room, reference: Reference) -> None:
    """Let what connections bring in reach the dictionary's entry, and the entry what they take out."""
    if reference.dictionary not in room.dictionaries:
        known = expected(reference.dictionary, room.dictionaries)
        network.problems.append(
            f"{reference.where}: no such dictionary, got {reference.dictionary!r}, {known}"
        )
        return
    owner, dictionary = room.dictionaries[reference.dictionary]
    for connector in reference.connectors.values():
        if connector.name not in dictionary.entries:
            known = expected(connector.name, dictionary.entries)
            network.problems.append(f"{connector.where}: no such entry in {dictionary.name!r}, {known}")
            continue
        entry = Point((*owner, dictionary.name), connector.name, "dictionary")
        into, out = (Point((*room.path, reference.name), connector.name, side) for side in ("in", "out"))
        _place(network, entry, "inout", dictionary.entries[connector.name])
        for point in (into, out):
            _place(network, point, connector.kind, connector.type)
        if into in network.into:
            edge = Edge(into, entry, True, None, connector.where)
            network.into.setdefault(entry, []).append(edge)
        network.into.setdefault(out, []).append(Edge(entry, out, True, None, connector.where))


def _refuse_second_sources(network: Network, edges: list[Edge]) -> None:
    target = edges[0].target
    for edge in edges[1:]:
        if target.side == "dictionary":
            fault = "is a bus with several sources, which is not understood"
        else:
            fault = "has two sources"
        network.problems.append(
            f"{edge.where}: {target} {fault}, got {edges[0].source} and {edge.source}, expected one"
        )


def sinks(network: Network) -> Iterator[tuple[Leaf, Connector, Point]]:
    """Connectors of components that take data."""
    for leaf in network.leaves.values():
        for connector in leaf.component.connectors.values():
            if connector.kind in INPUTS:
                yield leaf, connector, Point(leaf.path, connector.name)

"""From a structure to FMUs, wires between them and the values they start from: nesting is flattened here."""

from __future__ import annotations

import re
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path as FilePath

from master.errors import ConfigError
from master.fmi.units import Conversion, conversion

from .carry import carry
from .network import Edge, Leaf, Network, Path, Point, make_network, sinks, variable_of
from .parameters import Assignments, Bound, assign, through
from .structure import INPUTS, OUTPUTS, Structure

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
class Resolved:
    """A flat system; `notes` says what a user should know of how it was read."""

    fmus: Mapping[str, ResolvedFmu]
    wires: tuple[ResolvedWire, ...]
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
    if not network.leaves:
        problems.append(f"{structure.system.where}: nothing to step, got no component, expected an FMU")
    if problems:
        raise ConfigError(dict.fromkeys(problems))
    return _Flat(network, assigned, frozenset(trusted)).resolved(structure)


class _Flat:
    def __init__(self, network: Network, assigned: Assignments, trusted: Collection[tuple[str, str]]) -> None:
        self.network = network
        self.assigned = assigned
        self.trusted = trusted
        self.names = _names(network.leaves)
        self.problems: list[str] = []
        self.notes = list(assigned.notes)
        self.wires: list[ResolvedWire] = []
        self.starts: dict[Path, dict[str, Bound]] = {path: {} for path in network.leaves}
        self.inputs: dict[str, list[str]] = {}

    def resolved(self, structure: Structure) -> Resolved:
        for point, bound in self.assigned.values.items():
            if point.owner in self.starts:
                self.starts[point.owner][point.connector] = bound
        self._set_outputs()
        for leaf, _, point in sinks(self.network):
            self._feed(leaf, point)
        self._order_wires(structure)
        fmus = {self.names[path]: self._fmu(path, leaf) for path, leaf in self.network.leaves.items()}
        if self.problems:
            raise ConfigError(dict.fromkeys(self.problems))
        renamed = [
            f"{'.'.join(path)!r} is called {name!r} here"
            for path, name in self.names.items()
            if name != SEPARATOR.join(path)
        ]
        return Resolved(fmus, tuple(self.wires), (*self.notes, *renamed, *self._root_notes()))

    def _feed(self, leaf: Leaf, point: Point) -> None:
        """Wire an input to the output that it comes from, or start it from the connector's value."""
        path = self.network.source_of(point)
        if not path:
            return
        origin = path[0].source
        target = f"{self.names[leaf.path]}.{point.connector}"
        for passed in (edge.target for edge in path):
            if passed in self.assigned.values and (
                origin.owner in self.names or origin in self.assigned.values
            ):
                self._say_overridden(passed, origin)
        if not origin.owner:
            self.inputs.setdefault(origin.connector, []).append(target)
        try:
            if origin.owner in self.names:
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
        where = path[-1].where if len(path) == 1 else f"{path[0].where} ... {path[-1].where}"
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
            if origin.owner not in self.starts:
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

    def _order_wires(self, structure: Structure) -> None:
        """Keep the order of the file where the system is flat."""
        places = {link.where: i for i, link in enumerate(structure.system.links)}
        self.wires.sort(key=lambda wire: places.get(wire.where, len(places)))

    def _root_notes(self) -> list[str]:
        """What the outermost system's connectors are connected to."""
        roots = self.network.roots.values()
        taken = [
            f"{c.name} -> {', '.join(self.inputs.get(c.name, ['nothing']))}"
            for c in roots
            if c.kind in INPUTS
        ]
        given = [f"{c.name} = {self._said_output(Point((), c.name))}" for c in roots if c.kind not in INPUTS]
        return [
            f"{what} of the system: {'; '.join(found)}"
            for what, found in (("inputs", taken), ("outputs", given))
            if found
        ]

    def _said_output(self, point: Point) -> str:
        path = self.network.source_of(point)
        origin = path[0].source if path else None
        if origin is None or origin.owner not in self.names:
            return "nothing"
        name = f"{self.names[origin.owner]}.{origin.connector}"
        try:
            found = carry(self.network, path).conversion
        except ValueError as error:
            self.problems.append(str(error))
            return ""
        if found.is_identity:
            return name
        inner = name if found.is_affine else f"map({name})"
        return f"{found.factor:.15g} * {inner} + {found.offset:.15g}"


def _names(leaves: Mapping[Path, Leaf]) -> dict[Path, str]:
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

"""The variables of the fused FMU: those of all inner FMUs as `instance.variable`, by their roles."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

from master.coupling.schedule import Schedule
from master.errors import Problem
from master.fmi.description import Description, Variable
from master.fmi.units import Unit
from master.system.graph import Instance, System, Wire
from master.system.grid import Grid
from master.system.scenario import Scenario

from .inner import InnerModel, Row

PARAMETER = "PARAMETER"
INPUT = "INPUT"
STATE = "STATE"
OUTPUT = "OUTPUT"


@dataclass(frozen=True)
class Inner:
    """One instance of the system: its number, its model's sources and what the system says of it."""

    number: int
    model: InnerModel
    instance: Instance

    @property
    def name(self) -> str:
        """Name in the system."""
        return self.instance.name

    @property
    def member(self) -> str:
        """Name of its member of the memory in C."""
        return f"i{self.number}"

    @property
    def description(self) -> Description:
        """What its FMU says of itself."""
        return self.instance.description


@dataclass(frozen=True)
class FusedVariable:
    """
    One variable of the fused FMU; its place in the list of all is its value reference.

    `described` is what an FMU, or the system, says of it, None for a hidden one. `is_received`: an input of
    an inner FMU that a connection sets, which the fused one shows only.
    """

    name: str
    role: str
    start: float
    described: Variable | None
    row: Row
    is_received: bool = False

    @property
    def causality(self) -> str:
        """FMI causality; that of a hidden one is local."""
        if self.is_received or self.described is None:
            return "local"
        return self.described.causality

    @property
    def has_start(self) -> bool:
        """Whether a host may set it before the run, so that its start value is written."""
        return not self.is_received and self.described is not None and self.described.is_settable

    @property
    def start_text(self) -> str:
        """Start value as XML has it, exact to the last bit."""
        if self.row.type == "BOOLEAN":
            return "true" if self.start else "false"
        return repr(float(self.start)) if self.row.type == "REAL" else str(int(self.start))


@dataclass(frozen=True)
class InnerVariable(FusedVariable):
    """A variable of an inner FMU, `place` being that among its own."""

    inner: Inner = field(kw_only=True)
    place: int = field(kw_only=True)


def connector_variables(system: System) -> list[FusedVariable]:
    """Inputs and outputs of the system itself."""
    found = []
    for owner, description in system.connectors.items():
        for v in description.variables:
            name = f"{owner}.{v.name}"
            role = INPUT if v.causality == "input" else OUTPUT
            start = (connector_start(system, name) or 0.0) if role == INPUT else 0.0
            kind = "ENUMERATION" if v.items else v.kind.name
            row = Row(v.name, "", role, kind, False, False, start, "NULL", 0)
            found.append(FusedVariable(name, role, start, v, row))
    return found


def connector_start(system: System, name: str) -> float | None:
    """
    Value of an input of the system at the start.

    One that the system does not give is that with which all that it leads to starts as it does in `run`; None
    if there is none.
    """
    given = system.given.get(name)
    if given is not None:
        return float(given)
    wires = system.driven_by(name)
    if not wires:
        return 0.0
    starts = [_start_at(system, wire) for wire in wires]
    conversion = wires[0].conversion
    if conversion.table or conversion.factor == 0.0 or starts[0] is None:
        return None
    found = (starts[0] - conversion.offset) / conversion.factor
    is_that = all(wire.conversion.of(found) == start for wire, start in zip(wires, starts, strict=True))
    return found if is_that else None


def _start_at(system: System, wire: Wire) -> float | None:
    """Value at the end of a wire from an input of the system: of an FMU, or of an output of the system."""
    if wire.target.instance not in system.instances:
        return system.held.get(wire.target.name)
    value = system.instances[wire.target.instance].value_of(wire.target.variable.name)
    return None if value is None else float(value)


@dataclass(frozen=True)
class Fused:
    """
    A system that is exported as one FMU.

    `identifier` is its name as one of C, `grid` has the communication step of the system, `scenario` what
    happens during its runs.
    """

    name: str
    identifier: str
    description: str
    grid: Grid
    scenario: Scenario
    system: System
    schedule: Schedule
    models: tuple[InnerModel, ...]
    inners: Mapping[str, Inner]

    @cached_property
    def variables(self) -> tuple[FusedVariable, ...]:
        """All variables: parameters, inputs, states, outputs, and inputs of FMUs that connections set."""
        groups = [self._group(role) for role in (PARAMETER, INPUT, STATE, OUTPUT)]
        connected = {wire.target.name for wire in (*self.system.wires, *self.system.inlets)}
        free = [v for v in groups[1] if v.name not in connected]
        received = [replace(v, role=OUTPUT, is_received=True) for v in groups[1] if v.name in connected]
        given = connector_variables(self.system)
        inputs = [v for v in given if v.role == INPUT]
        outputs = [v for v in given if v.role == OUTPUT]
        return (*groups[0], *free, *inputs, *groups[2], *groups[3], *received, *outputs)

    @cached_property
    def reference_of(self) -> Mapping[str, int]:
        """Value references by name."""
        return {v.name: i for i, v in enumerate(self.variables)}

    @property
    def has_foreign(self) -> bool:
        """Whether FMUs are carried along as they are."""
        return any(model.is_foreign for model in self.models)

    @property
    def saves_state(self) -> bool:
        """Whether the host can save and restore the state: all FMUs that are carried along can."""
        return all(i.description.can_get_and_set_state for i in self.inners.values() if i.model.is_foreign)

    @cached_property
    def units(self) -> Mapping[str, Unit]:
        """Units of all that is shown, by name; where one FMU defines it and another does not, as defined."""
        found: dict[str, Unit] = {}
        for _, unit in self._with_units():
            if not found.setdefault(unit.name, unit).defined:
                found[unit.name] = unit
        return found

    def unit_problems(self) -> list[Problem]:
        """Say which units of one name are different ones: an FMU has one meaning for each name."""
        known: dict[str, tuple[FusedVariable, Unit]] = {}
        problems = []
        for v, unit in self._with_units():
            if not unit.defined:
                continue
            other, meant = known.setdefault(unit.name, (v, unit))
            if not _are_alike(unit, meant):
                known[unit.name] = (v, unit)
                instance, _, name = v.name.partition(".")
                what = f"unit {unit.name!r} of {name} is another than that of {other.name}"
                where = f"fmus.{instance}"
                problems.append(Problem(what, where=where, expected="one meaning of each name"))
        return problems

    def _with_units(self) -> Iterator[tuple[FusedVariable, Unit]]:
        """Variables that are shown with a unit."""
        for v in self.variables:
            unit = None if v.described is None or v.row.type != "REAL" else v.described.unit
            if unit is not None:
                yield v, unit

    def of_role(self, role: str) -> Sequence[FusedVariable]:
        """Variables of one role; those that are received are outputs in this sense."""
        return [v for v in self.variables if v.role == role]

    def _group(self, role: str) -> list[InnerVariable]:
        found = []
        for inner in self.inners.values():
            for place, row in enumerate(inner.model.rows):
                if row.role == role:
                    start, described = _start(inner, row)
                    name = f"{inner.name}.{row.name}"
                    found.append(InnerVariable(name, role, start, described, row, inner=inner, place=place))
        return found


def _are_alike(one: Unit, other: Unit) -> bool:
    """Whether two units mean the same, their factors rounded differently perhaps."""
    numbers = ((one.factor, other.factor), (one.offset, other.offset))
    return one.exponents == other.exponents and all(math.isclose(a, b, rel_tol=1e-9) for a, b in numbers)


def _start(inner: Inner, row: Row) -> tuple[float, Variable | None]:
    """Start value in the system, and what the FMU says of the variable."""
    described = None if row.is_hidden else inner.description.by_name.get(row.name)
    given = inner.instance.start.get(row.name)
    return row.start if given is None else float(given), described

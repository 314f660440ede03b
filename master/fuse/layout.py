"""The variables of the fused FMU: those of all inner FMUs as `instance.variable`, by their roles."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

from master.coupling.schedule import Schedule
from master.fmi.description import Description, Variable
from master.system.graph import Instance, System
from master.system.grid import Grid

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

    `place` is that in the inner FMU. `described` is what that FMU says of it, None for a hidden one.
    `is_received`: an input of the inner FMU that a connection sets, which the fused one shows only.
    """

    inner: Inner
    place: int
    role: str
    start: float
    described: Variable | None
    is_received: bool = False

    @property
    def row(self) -> Row:
        """What the inner model's table says of it."""
        return self.inner.model.rows[self.place]

    @property
    def name(self) -> str:
        """Name in the fused FMU."""
        return f"{self.inner.name}.{self.row.name}"

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
class Fused:
    """
    A system that is exported as one FMU.

    `identifier` is its name as one of C, `step` the communication step of the system [s].
    """

    name: str
    identifier: str
    description: str
    grid: Grid
    system: System
    schedule: Schedule
    models: tuple[InnerModel, ...]
    inners: Mapping[str, Inner]

    @cached_property
    def variables(self) -> tuple[FusedVariable, ...]:
        """All variables: parameters, inputs, states, outputs, and inputs of FMUs that connections set."""
        groups = [self._group(role) for role in (PARAMETER, INPUT, STATE, OUTPUT)]
        connected = {wire.target.name for wire in self.system.wires}
        free = [v for v in groups[1] if v.name not in connected]
        received = [
            FusedVariable(v.inner, v.place, OUTPUT, v.start, v.described, is_received=True)
            for v in groups[1]
            if v.name in connected
        ]
        return (*groups[0], *free, *groups[2], *groups[3], *received)

    @cached_property
    def reference_of(self) -> Mapping[str, int]:
        """Value references by name."""
        return {v.name: i for i, v in enumerate(self.variables)}

    @property
    def has_foreign(self) -> bool:
        """Whether FMUs are carried along as they are."""
        return any(model.is_foreign for model in self.models)

    def of_role(self, role: str) -> Sequence[FusedVariable]:
        """Variables of one role; those that are received are outputs in this sense."""
        return [v for v in self.variables if v.role == role]

    def _group(self, role: str) -> list[FusedVariable]:
        return [
            FusedVariable(inner, place, row.role, *_start(inner, row))
            for inner in self.inners.values()
            for place, row in enumerate(inner.model.rows)
            if row.role == role
        ]


def _start(inner: Inner, row: Row) -> tuple[float, Variable | None]:
    """Start value in the system, and what the FMU says of the variable."""
    described = None if row.is_hidden else inner.description.by_name.get(row.name)
    given = inner.instance.start.get(row.name)
    return row.start if given is None else float(given), described

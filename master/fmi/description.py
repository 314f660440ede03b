"""What an FMU says of itself: modelDescription.xml as frozen data. No FMU is loaded."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import Enum
from functools import cached_property
from pathlib import Path

from . import value_types
from .linearity import DeclaredLearning, DeclaredLinear
from .units import Unit

_OWN_TOOL = "dockloop (native flavour)"


class Kind(Enum):
    """What sort of value a variable takes."""

    REAL = "Real"
    INTEGER = "Integer"
    BOOLEAN = "Boolean"
    STRING = "String"


@dataclass(frozen=True, slots=True)
class Variable:
    """
    One scalar variable of an FMU, or one element of an array (FMI 3.0).

    The elements of an array share its `reference` and have its name as `array`; `size` is their number,
    `element` counts from 0 in row-major order. Their names are `name[1]`, `name[2]`, ... or `name[1,1]`,
    `name[1,2]`, ...

    Variables that share a value are aliases: one of them is the primary one, which can be set if any can,
    and the others name it as `alias_of`. Attributes of a declared type count where the variable has none.
    """

    name: str
    reference: int
    kind: Kind
    value_type: int
    causality: str
    variability: str
    initial: str | None = None
    start: str | None = None
    unit: Unit | None = None
    minimum: float | None = None
    maximum: float | None = None
    nominal: float | None = None
    items: Mapping[str, int] = field(default_factory=dict)
    description: str = ""
    size: int = 1
    element: int | None = None
    array: str | None = None
    alias_of: str | None = None
    display_unit: str | None = None
    quantity: str | None = None

    @property
    def unit_name(self) -> str:
        """Name of the unit, `1` if it has none."""
        return self.unit.name if self.unit else "1"

    @property
    def is_settable(self) -> bool:
        """Whether it takes a value before the run."""
        if self.variability == "constant":
            return False
        return self.causality in ("parameter", "input") or self.initial in ("exact", "approx")

    @property
    def is_structural(self) -> bool:
        """Whether it is a structural parameter (FMI 3.0), which sizes of arrays may depend on."""
        return self.causality == "structuralParameter"

    @property
    def start_value(self) -> float | str | None:
        """The FMU's own start value, also where it is outside the FMU's own bounds; 64-bit integers exact."""
        if self.start is None or self.kind is Kind.STRING:
            return self.start
        if self.kind is Kind.BOOLEAN:
            return float(self.start in ("true", "1"))
        if self.kind is Kind.INTEGER:
            number = int(self.start)
            return number if self.value_type in value_types.LONG else float(number)
        return float(self.start)


@dataclass(frozen=True)
class DeclaredDelay:
    """A delay that the FMU declares of itself; see `fmu_sources.framework.model.Delay`."""

    input: str
    kind: str
    seconds: str
    steps: float | None
    by: str | None
    cases: Mapping[str, float]
    reason: str


@dataclass(frozen=True)
class Description:
    """
    One FMU for co-simulation.

    `not_exchanged` says of each variable that the master neither sets nor gets what it is;
    `ticked_clocks` are those that an FMU in event mode expects the master to tick; `short_starts` are the
    arrays whose start list does not have a value for each element.
    """

    path: Path
    fmi_version: str
    model_name: str
    model_identifier: str
    token: str
    variables: tuple[Variable, ...]
    tool: str = ""
    delays: tuple[DeclaredDelay, ...] = ()
    can_get_and_set_state: bool = False
    can_serialise_state: bool = False
    needs_execution_tool: bool = False
    once_per_process: bool = False
    has_event_mode: bool = False
    not_exchanged: Mapping[str, str] = field(default_factory=dict)
    ticked_clocks: tuple[str, ...] = ()
    short_starts: frozenset[str] = frozenset()
    feedthrough: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    influences: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    linear: tuple[DeclaredLinear, ...] = ()
    learning: tuple[DeclaredLearning, ...] = ()

    @property
    def keeps_float_mode(self) -> bool:
        """Whether its code is of this project, which never changes the processor's floating-point mode."""
        return self.tool == _OWN_TOOL

    @cached_property
    def version(self) -> int:
        """Major version of FMI."""
        return int(self.fmi_version.partition(".")[0])

    @cached_property
    def by_name(self) -> dict[str, Variable]:
        """Variables by name."""
        return {v.name: v for v in self.variables}

    @cached_property
    def arrays(self) -> dict[str, tuple[Variable, ...]]:
        """Elements of the arrays by the name of the whole."""
        found: dict[str, list[Variable]] = {}
        for v in self.variables:
            if v.array is not None:
                found.setdefault(v.array, []).append(v)
        return {name: tuple(elements) for name, elements in found.items()}

    @cached_property
    def inputs_in_arrays(self) -> tuple[Variable, ...]:
        """Inputs that are elements of arrays."""
        return tuple(v for v in self.variables if v.array is not None and v.causality == "input")

    def primary(self, name: str) -> Variable:
        """Find a variable, or the primary one of those that share its value; KeyError if there is none."""
        variable = self.by_name[name]
        return variable if variable.alias_of is None else self.by_name[variable.alias_of]

    @property
    def can_share_library(self) -> bool:
        """Whether two instances may live in one library: not where an interpreter hides in it."""
        return not (self.once_per_process or self.needs_execution_tool)

    @cached_property
    def _direct_inputs(self) -> dict[str, frozenset[str]]:
        sets = {
            id(names): frozenset(names) for names in {id(n): n for n in self.feedthrough.values()}.values()
        }
        return {output: sets[id(names)] for output, names in self.feedthrough.items()}

    def hands_through(self, input_name: str, output_name: str) -> bool:
        """Whether an output may follow an input at once."""
        return input_name in self._direct_inputs.get(output_name, ())

    def reaches(self, input_name: str, output_name: str) -> bool:
        """Whether an input acts on an output sooner or later; yes where the FMU does not say."""
        return output_name not in self.influences or input_name in self.influences[output_name]

    @cached_property
    def outputs(self) -> tuple[Variable, ...]:
        """Outputs that can be recorded, in declared order."""
        return tuple(v for v in self.variables if v.causality == "output" and v.kind is not Kind.STRING)

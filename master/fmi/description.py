"""What an FMU says of itself: modelDescription.xml as frozen data. No FMU is loaded."""

from __future__ import annotations

import zipfile
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from enum import Enum
from functools import cached_property
from pathlib import Path
from typing import Any
from xml.etree import ElementTree as ET

from master.errors import ConfigError

from . import value_types
from .arrays import element_names, elements, first_number, is_ticked, not_exchanged
from .linearity import DeclaredLearning, DeclaredLinear, declared_learning, declared_linear
from .units import Unit, units_of


class Kind(Enum):
    """What sort of value a variable takes."""

    REAL = "Real"
    INTEGER = "Integer"
    BOOLEAN = "Boolean"
    STRING = "String"


@dataclass(frozen=True)
class Variable:
    """
    One scalar variable of an FMU, or one element of an array (FMI 3.0).

    The elements of an array share its `reference`; `size` is their number, `element` counts from 0 in
    row-major order. Their names are `name[1]`, `name[2]`, ... or `name[1,1]`, `name[1,2]`, ...
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

    @property
    def unit_name(self) -> str:
        """Name of the unit, `1` if it has none."""
        return self.unit.name if self.unit else "1"


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
    `ticked_clocks` are those that an FMU in event mode expects the master to tick.
    """

    path: Path
    fmi_version: str
    model_name: str
    model_identifier: str
    token: str
    variables: tuple[Variable, ...]
    delays: tuple[DeclaredDelay, ...] = ()
    can_get_and_set_state: bool = False
    needs_execution_tool: bool = False
    once_per_process: bool = False
    has_event_mode: bool = False
    not_exchanged: Mapping[str, str] = field(default_factory=dict)
    ticked_clocks: tuple[str, ...] = ()
    feedthrough: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    influences: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    linear: tuple[DeclaredLinear, ...] = ()
    learning: tuple[DeclaredLearning, ...] = ()

    @property
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
        found: dict[str, tuple[Variable, ...]] = {}
        for v in self.variables:
            if v.element is not None:
                name = v.name.rpartition("[")[0]
                found[name] = (*found.get(name, ()), v)
        return found

    @property
    def can_share_library(self) -> bool:
        """Whether two instances may live in one library: not where an interpreter hides in it."""
        return not (self.once_per_process or self.needs_execution_tool)

    def reaches(self, input_name: str, output_name: str) -> bool:
        """Whether an input acts on an output sooner or later; yes where the FMU does not say."""
        return output_name not in self.influences or input_name in self.influences[output_name]

    @cached_property
    def outputs(self) -> tuple[Variable, ...]:
        """Outputs that can be recorded, in declared order."""
        return tuple(v for v in self.variables if v.causality == "output" and v.kind is not Kind.STRING)


def read_description(path: Path) -> Description:
    """
    Read the model description of an FMU 2.0 or 3.0 for co-simulation.

    Raises:
        ConfigError: If the file is not such an FMU.
    """
    root = _read_xml(path)
    version = root.get("fmiVersion", "")
    if not version.startswith(("2.", "3.")):
        raise ConfigError(
            [f"{path}: FMI version not supported, got {version or 'none'!r}, expected 2.0 or 3.0"]
        )
    try:
        return _described(path, root, version)
    except ConfigError:
        raise
    except Exception as error:  # FMPy raises bare Exception; a number may be none
        raise ConfigError([f"{path}: model description cannot be read: {error}"]) from None


def _described(path: Path, root: ET.Element, version: str) -> Description:
    from fmpy import read_model_description

    model = read_model_description(str(path), validate=False)
    if model.coSimulation is None:
        raise ConfigError([f"{path}: not for co-simulation, got an FMU for model exchange only"])
    if not (model.coSimulation.modelIdentifier and (model.guid or model.instantiationToken)):
        raise ValueError("modelIdentifier or guid (instantiationToken) is missing")
    return Description(
        path=path,
        fmi_version=version,
        model_name=model.modelName,
        model_identifier=model.coSimulation.modelIdentifier,
        token=model.guid or model.instantiationToken,
        variables=_variables(model, version, units_of(model, root)),
        delays=tuple(_delays(root)),
        can_get_and_set_state=bool(model.coSimulation.canGetAndSetFMUstate),
        needs_execution_tool=bool(model.coSimulation.needsExecutionTool),
        once_per_process=bool(model.coSimulation.canBeInstantiatedOnlyOncePerProcess),
        has_event_mode=bool(model.coSimulation.hasEventMode),
        not_exchanged={v.name: what for v in model.modelVariables if (what := not_exchanged(v))},
        ticked_clocks=tuple(v.name for v in model.modelVariables if is_ticked(v)),
        feedthrough=_feedthrough(model),
        influences={
            e.get("output", ""): tuple((e.get("inputs") or "").split()) for e in root.iter("Influence")
        },
        linear=declared_linear(root),
        learning=declared_learning(root),
    )


def _variables(model: Any, version: str, units: Mapping[str, Unit]) -> tuple[Variable, ...]:
    """All variables that the master exchanges, arrays by their elements."""
    exchanged = (v for v in model.modelVariables if not not_exchanged(v))
    return tuple(part for v in exchanged for part in _elements(_variable(v, units.get(v.name), version), v))


def _elements(whole: Variable, v: Any) -> list[Variable]:
    """The variable itself, or one for each element of an array."""
    if not v.dimensions:
        return [whole]
    parts = elements(v)
    return [
        replace(whole, name=part.name, start=part.start, size=len(parts), element=part.number)
        for part in parts
    ]


def completed(variables: Sequence[Variable], known: Sequence[Variable]) -> list[Variable]:
    """Complete the arrays of which a list has elements, in the order of the array."""
    arrays = dict.fromkeys(v.reference for v in variables if v.element is not None)
    whole = [v for reference in arrays for v in known if v.reference == reference]
    return [v for v in variables if v.element is None] + whole


def _read_xml(path: Path) -> ET.Element:
    try:
        with zipfile.ZipFile(path) as archive:
            return ET.fromstring(archive.read("modelDescription.xml"))
    except FileNotFoundError:
        raise ConfigError([f"{path}: no such file, expected an FMU"]) from None
    except (OSError, zipfile.BadZipFile):
        raise ConfigError([f"{path}: not an FMU, expected a zip archive with modelDescription.xml"]) from None
    except KeyError:
        raise ConfigError([f"{path}: not an FMU, expected modelDescription.xml in the archive"]) from None
    except ET.ParseError as error:
        raise ConfigError([f"{path}: modelDescription.xml is not XML: {error}"]) from None


_KINDS = {
    **dict.fromkeys(("Real", "Float64", "Float32"), Kind.REAL),
    "Boolean": Kind.BOOLEAN,
    "String": Kind.STRING,
}
_TYPES_2 = {"Real": value_types.FLOAT64, "Boolean": value_types.INT_BOOLEAN}


def _value_type(name: str, version: str) -> int:
    """Code of a variable's type on the C interface: an FMI 2.0 Boolean or enumeration is an int."""
    if version.startswith("2."):
        return _TYPES_2.get(name, value_types.INT32)
    return value_types.NAMES.index(name) if name in value_types.NAMES else value_types.INT64


def _start(v: Any, kind: Kind) -> str | None:
    """Start value as it is written; ValueError if it is none of the variable's kind."""
    for word in () if kind is Kind.STRING or v.start is None else str(v.start).split():
        if not (kind is Kind.BOOLEAN and word in ("true", "false")):
            try:
                float(word)
            except ValueError:
                raise ValueError(f"start value of {v.name} is not a {kind.value}, got {v.start!r}") from None
    return v.start  # type: ignore[no-any-return]


def _variable(v: Any, unit: Unit | None, version: str) -> Variable:
    declared = v.declaredType
    items = {i.name: int(i.value) for i in declared.items} if declared is not None and declared.items else {}
    return Variable(
        name=v.name,
        reference=v.valueReference,
        kind=_KINDS.get(v.type, Kind.INTEGER),
        value_type=_value_type(v.type, version),
        causality=v.causality,
        variability=v.variability,
        initial=v.initial,
        start=_start(v, _KINDS.get(v.type, Kind.INTEGER)),
        unit=unit,
        minimum=first_number(v.min),
        maximum=first_number(v.max),
        nominal=first_number(v.nominal),
        items=items,
        description=v.description or "",
    )


def _number(text: Any) -> float | None:
    return None if text is None else float(text)


def _feedthrough(model: Any) -> dict[str, tuple[str, ...]]:
    """Inputs that each output hangs on at once; all inputs where the FMU does not say."""
    every = _inputs(model.modelVariables)
    said = {u.variable.name: u.dependencies for u in model.outputs if u.dependencies is not None}
    return {
        name: _inputs(said[v.name]) if v.name in said else every
        for v in model.modelVariables
        if v.causality == "output"
        for name in element_names(v)
    }


def _inputs(variables: Any) -> tuple[str, ...]:
    return tuple(name for v in variables if v.causality == "input" for name in element_names(v))


def _delays(root: ET.Element) -> list[DeclaredDelay]:
    return [
        DeclaredDelay(
            input=e.get("input", ""),
            kind=e.get("kind", ""),
            seconds=e.get("seconds", "0"),
            steps=_number(e.get("steps")),
            by=e.get("by"),
            cases={w.get("item", ""): float(w.get("steps", "0")) for w in e.iter("When")},
            reason=e.get("reason", ""),
        )
        for e in root.iter("Delay")
    ]

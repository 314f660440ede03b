"""What an FMU says of itself, and what is odd about it; none of its code is run."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any
from xml.etree import ElementTree as ET

from master.errors import ConfigError
from master.text.archive import Archive

from .description import Description, Kind, Variable
from .description_reader import DESCRIPTION
from .unpacked import require_runnable
from .values import start_notes

_MOST_NAMES = 8  # of one kind of oddity
_TERMINALS = "terminalsAndIcons/terminalsAndIcons.xml"
_TRUTHS = {"true": True, "1": True, "false": False, "0": False}


@dataclass(frozen=True)
class InspectedVariable:
    """One variable as its FMU declares it; `start` is a number, a text, the name of an item, or None."""

    name: str
    causality: str
    variability: str
    type: str
    unit: str
    start: float | str | bool | None
    minimum: float | None
    maximum: float | None
    items: Mapping[str, int]
    description: str


@dataclass(frozen=True)
class Inspection:
    """An FMU: variables, capabilities of its interface, folders of binaries, terminals, what is odd."""

    path: Path
    name: str
    variables: tuple[InspectedVariable, ...]
    capabilities: Mapping[str, str | bool]
    platforms: tuple[str, ...]
    has_sources: bool
    terminals: Mapping[str, Mapping[str, str]]
    terminal_kinds: Mapping[str, str]
    odd: tuple[str, ...]

    def as_dict(self) -> dict[str, Any]:
        """All of it, for JSON."""
        return asdict(self) | {"path": str(self.path)}


def inspect_fmu(description: Description) -> Inspection:
    """
    Look into the file of a description.

    Raises:
        ConfigError: If the archive cannot be read.
    """
    with Archive(description.path) as archive:
        names = archive.names
        root = ET.fromstring(archive.read(DESCRIPTION))
        terminals = _terminals(archive.read(_TERMINALS)) if _TERMINALS in names else []
    binaries = [name.split("/") for name in names if name.startswith("binaries/")]
    platforms = sorted({parts[1] for parts in binaries if len(parts) > 2})
    return Inspection(
        path=description.path,
        name=description.model_name,
        variables=tuple(map(_inspected, description.variables)),
        capabilities=_capabilities(root, description),
        platforms=tuple(platforms),
        has_sources=any(name.startswith("sources/") for name in names),
        terminals={terminal.get("name", ""): _members(terminal) for terminal in terminals},
        terminal_kinds={t.get("name", ""): t.get("terminalKind", "") for t in terminals},
        odd=tuple(_oddities(description)),
    )


def _inspected(v: Variable) -> InspectedVariable:
    return InspectedVariable(
        name=v.name,
        causality=v.causality,
        variability=v.variability,
        type="Enumeration" if v.items else v.kind.value,
        unit=v.unit_name,
        start=_start(v),
        minimum=v.minimum,
        maximum=v.maximum,
        items=dict(v.items),
        description=v.description,
    )


def _start(v: Variable) -> float | str | bool | None:
    value = v.start_value
    if value is None or isinstance(value, str):
        return value
    if v.kind is Kind.BOOLEAN:
        return bool(value)
    return next((name for name, number in v.items.items() if number == value), value)


def _capabilities(root: ET.Element, description: Description) -> dict[str, str | bool]:
    """Attributes of the interface for co-simulation, with those that are not said left out."""
    interface = root.find("CoSimulation")
    said = {} if interface is None else dict(interface.attrib)
    said.pop("modelIdentifier", None)
    found: dict[str, str | bool] = {"fmi_version": description.fmi_version}
    tool = root.get("generationTool")
    if tool:
        found["generation_tool"] = tool
    experiment = root.find("DefaultExperiment")
    found |= {} if experiment is None else dict(experiment.attrib)
    found["model_exchange"] = root.find("ModelExchange") is not None
    return found | {key: _TRUTHS.get(value, value) for key, value in said.items()}


def _terminals(content: bytes) -> list[ET.Element]:
    """Terminals of FMI 3.0; none where their file is no XML."""
    try:
        return list(ET.fromstring(content).iter("Terminal"))
    except ET.ParseError:
        return []


def _members(terminal: ET.Element) -> dict[str, str]:
    """Members of a terminal and their variables."""
    found = terminal.iter("TerminalMemberVariable")
    return {member.get("memberName", ""): member.get("variableName", "") for member in found}


def _oddities(d: Description) -> Iterator[str]:
    try:
        require_runnable([d])
    except ConfigError as error:
        yield from (f"{p.what}, got {p.got}" if p.got else p.what for p in error.problems)
    if d.needs_execution_tool:
        yield "needs another program on this machine to run (needsExecutionTool)"
    if d.once_per_process:
        yield "can be instantiated once in a process"
    if not d.can_get_and_set_state:
        yield "cannot save its state: no iteration, no linearisation of its states, no Simulation.save"
    elif not d.can_serialise_state:
        yield "cannot write its state to a file (canSerializeFMUstate): no run --checkpoint"
    if d.has_event_mode:
        yield "works in event mode: the master leads it through its events at each step"
    shown = ("input", "output", "parameter")
    reals = [v for v in d.variables if v.kind is Kind.REAL and v.causality in shown]
    undefined = [v.name for v in reals if v.unit is not None and not v.unit.defined]
    if undefined:
        yield f"names units without defining them: {_some(undefined)}"
    without = [v.name for v in reals if v.unit is None]
    if without:
        yield f"has no unit for {_some(without)}: taken as they are, whatever they are connected to"
    if d.not_exchanged:
        kinds = [f"{name} ({what})" for name, what in d.not_exchanged.items()]
        yield f"has variables that are not exchanged: {_some(kinds)}"
    if d.short_starts:
        yield f"has arrays with fewer start values than elements: {_some(sorted(d.short_starts))}"
    yield from start_notes(d, ())


def _some(names: list[str]) -> str:
    more = f" and {len(names) - _MOST_NAMES} more" if len(names) > _MOST_NAMES else ""
    return ", ".join(names[:_MOST_NAMES]) + more

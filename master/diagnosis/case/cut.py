"""
Cut a system where signals were measured: each part is replayed alone, on measured inputs.

A connection into an input that was recorded is cut. FMUs that are still connected form one part; a residual
of a part points to its FMUs alone.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal, NamedTuple

from fmu_sources.composed import registry
from fmu_sources.composed.composition import all_slots
from fmu_sources.framework.model import Model, Slot
from master import catalogue
from master.coupling.schedule import make_schedule
from master.errors import ConfigError, expected
from master.fmi.description import Description
from master.fmi.description_reader import read_description
from master.fmi.units import Conversion
from master.fmi.values import parse
from master.system.config import UNKNOWN_SOURCE, Config, LoadedConfig, read_config
from master.system.graph import System, Wire, join
from master.text.signal_name import SignalName

from .case import Case, LoadedCase
from .faults import faults

Values = dict[str, dict[str, float | str]]


class MeasuredInput(NamedTuple):
    """A signal that drives an input, and whether a step takes its row at the start or at the end."""

    signal: str
    row: Literal["start", "end"]


@dataclass(frozen=True)
class CutPart:
    """
    FMUs in the order in which they step, with what drives them and what they are compared with.

    `inputs`: FMU to variable to what was measured of it. `wired`: FMU to variable to the output
    `instance.variable` that drives it, `conversions`: input `instance.variable` to what becomes of the
    value on its wire. `compared`: output `instance.variable` to signal. `foreign`: FMUs of which no model is
    known.
    """

    fmus: tuple[str, ...]
    inputs: Mapping[str, Mapping[str, MeasuredInput]]
    wired: Mapping[str, Mapping[str, str]]
    compared: Mapping[str, str]
    foreign: frozenset[str] = frozenset()
    conversions: Mapping[str, Conversion] = field(default_factory=dict)

    @property
    def begins_before_its_rows(self) -> bool:
        """Whether the first row may be what a foreign FMU made of an input before the recording."""
        return any(m.row == "start" for fmu in self.foreign for m in self.inputs[fmu].values())

    @property
    def columns(self) -> list[MeasuredInput]:
        """What drives the part, each once: the columns of a table of inputs."""
        return list(dict.fromkeys(m for inputs in self.inputs.values() for m in inputs.values()))

    @property
    def name(self) -> str:
        """Names of its FMUs."""
        return " and ".join(self.fmus)


@dataclass(frozen=True)
class CutSystem:
    """The system of a case: sources and start values of all FMUs, and the parts that are compared."""

    config: Config
    folder: Path
    sources: Mapping[str, str]
    values: Values
    descriptions: Mapping[str, Description]
    parts: tuple[CutPart, ...]

    def model(self, fmu: str) -> Model | None:
        """Model that an FMU was built from; None for a foreign file."""
        source = self.sources[fmu]
        return None if catalogue.is_path(source) else registry.load(source)

    def slots(self, fmu: str) -> dict[str, Slot]:
        """Slots of an FMU by name."""
        model = self.model(fmu)
        return {} if model is None else {s.name: s for s in all_slots(model)}


def cut(loaded: LoadedCase, progress: catalogue.Progress = catalogue.silent) -> CutSystem:
    """
    Read the system of a case and cut it.

    Raises:
        ConfigError: With every fault: of the system, or of the names that the case uses in it.
    """
    config = _config(loaded)
    system, sources, problems = _system(config, loaded, progress)
    problems += faults(loaded, system, sources)
    if not problems:
        problems += _wire_faults(loaded, system)
    if problems:
        raise ConfigError(problems)
    schedule = make_schedule(system, config.config.coupling.order, config.where("coupling", "order"))
    order = schedule.order
    values: Values = {name: dict(i.start) for name, i in system.instances.items()}
    for signal, value in loaded.case.set.items():
        name, variable = SignalName(signal).parts
        values[name][variable] = parse(system.port(signal).variable, value)
    foreign = {name for name, source in sources.items() if catalogue.is_path(source)}
    return CutSystem(
        config=config.config,
        folder=config.folder,
        sources=sources,
        values=values,
        descriptions={name: i.description for name, i in system.instances.items()},
        parts=_parts(loaded, system, order, foreign),
    )


def _config(loaded: LoadedCase) -> LoadedConfig:
    case = loaded.case
    if case.system is not None:
        return read_config(loaded.document.path.parent / case.system)
    config = Config.model_validate({"name": case.name, "stop_time": 1.0, "fmus": case.fmus})
    return LoadedConfig(config=config, document=loaded.document)


def _system(
    config: LoadedConfig, loaded: LoadedCase, progress: catalogue.Progress
) -> tuple[System, dict[str, str], list[str]]:
    """Join the system as far as it is right: the system, the source of each FMU, and all faults."""
    problems: list[str] = list(config.problems)
    targets = {}
    entries = config.config.fmus
    for name, entry in entries.items():
        if entry.source == UNKNOWN_SOURCE:
            continue
        try:
            targets[name] = catalogue.locate(entry.source, config.folder, "native")
        except ConfigError as error:
            problems += [p.at(config.where("fmus", name, "source")) for p in error.problems]
    if problems:  # nothing is built for a system that is refused
        targets = {name: t for name, t in targets.items() if catalogue.is_ready(t)}
    descriptions: dict[str, Description | None] = dict.fromkeys(config.document.names_in("fmus"))
    descriptions |= dict.fromkeys(entries)
    for name, file in catalogue.files(targets, progress).items():
        try:
            descriptions[name] = read_description(file)
        except ConfigError as error:
            problems += [p.at(config.where("fmus", name, "source")) for p in error.problems]
    overrides = {}
    variant = loaded.case.variant
    variants = config.config.variants
    if variant is not None and variant not in variants:
        hint = expected(variant, variants)
        problems.append(f"{loaded.where('variant')}: no such variant, got {variant!r}, {hint}")
    for fmu, given in variants.get(variant or "", {}).items():
        for key, value in given.items():
            overrides[f"{fmu}.{key}"] = (config.where("variants", variant or "", fmu, key), value)
    sources = {name: catalogue.model_name(entries[name].source, target) for name, target in targets.items()}
    system, faults_of_system = join(config, descriptions, overrides)
    return system, sources, problems + faults_of_system


def _parts(
    loaded: LoadedCase, system: System, order: list[str], foreign: Collection[str] = ()
) -> tuple[CutPart, ...]:
    case = loaded.case
    group = {name: name for name in order}
    unmeasured = [w for w in system.wires if w.target.name not in case.inputs]
    needed = _needed(case.compared, [(w.source.instance, w.target.instance) for w in unmeasured])
    wires = _replayed_wires(case, system)
    for w in wires:
        old = group[w.target.instance]
        new = group[w.source.instance]
        group = {name: new if g == old else g for name, g in group.items()}
    parts = []
    for first in dict.fromkeys(group[name] for name in order if name in needed):
        members = tuple(name for name in order if group[name] == first and name in needed)
        inputs = {name: _inputs(loaded, system, name, foreign) for name in members}
        wired = {
            name: {w.target.variable.name: w.source.name for w in wires if w.target.instance == name}
            for name in members
        }
        compared = {k: s for k, s in case.compared.items() if SignalName(k).instance in members}
        parts.append(
            CutPart(
                fmus=members,
                inputs=inputs,
                wired=wired,
                compared=compared,
                foreign=frozenset(foreign) & set(members),
                conversions={w.target.name: w.conversion for w in wires if w.target.instance in members},
            )
        )
    return tuple(parts)


def _replayed_wires(case: Case, system: System) -> list[Wire]:
    """Wires between FMUs that act on something compared, into inputs that were not measured."""
    wires = [w for w in system.wires if w.target.name not in case.inputs]
    needed = _needed(case.compared, [(w.source.instance, w.target.instance) for w in wires])
    return [w for w in wires if w.source.instance in needed and w.target.instance in needed]


def _wire_faults(loaded: LoadedCase, system: System) -> Iterator[str]:
    """Wires of a part that a replay would take without their delay or their extrapolation."""
    for w in _replayed_wires(loaded.case, system):
        if w.delay or w.extrapolation:
            got = f"delay {w.delay} and extrapolation {w.extrapolation}"
            yield (
                f"{loaded.where('inputs')}: {w.source.name} -> {w.target.name}, got {got}, expected none in "
                f"a wire that is replayed: name in `inputs` what was measured of {w.target.name}"
            )


def _needed(compared: Mapping[str, str], wires: list[tuple[str, str]]) -> set[str]:
    """FMUs that act on something compared."""
    needed = {SignalName(key).instance for key in compared}
    for _ in wires:
        needed |= {source for source, target in wires if target in needed}
    return needed


def _inputs(
    loaded: LoadedCase, system: System, name: str, foreign: Collection[str]
) -> Mapping[str, MeasuredInput]:
    """
    Measured inputs of an FMU by variable, each with the row it is taken from.

    One that a compared output follows at once, or may follow as far as the FMU says, is that of the
    output's row; so is one that the FMU interpolates to the end of the step. What only carries a signal to a
    foreign FMU at once hands it the row that this takes.
    """
    compared = [SignalName(key) for key in loaded.case.compared]
    inputs: dict[str, MeasuredInput] = {}
    for key, entry in loaded.case.inputs.items():
        fmu, variable = SignalName(key).parts
        if fmu == name:
            carried = _carried(system, name, variable, foreign)
            row = _row(system, *(carried or (name, variable)), compared)
            inputs[variable] = MeasuredInput(entry.signal, entry.at or row)
    return inputs


def _row(system: System, name: str, variable: str, compared: Sequence[SignalName]) -> Literal["start", "end"]:
    description = system.instances[name].description
    outputs = [signal.variable for signal in compared if signal.instance == name]
    follows = any(description.hands_through(variable, output) for output in outputs)
    return "end" if "input_hold" in description.by_name or follows else "start"


def _carried(system: System, name: str, variable: str, foreign: Collection[str]) -> tuple[str, str] | None:
    """Input of a foreign FMU that an FMU of our own carries one of its inputs to, at once."""
    description = system.instances[name].description
    if name in foreign:
        return None
    for w in system.wires:
        is_from_here = w.source.instance == name and w.target.instance in foreign
        if is_from_here and description.hands_through(variable, w.source.variable.name):
            return w.target.instance, w.target.variable.name
    return None

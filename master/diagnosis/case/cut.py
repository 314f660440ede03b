"""
Cut a system where signals were measured: each part is replayed alone, on measured inputs.

A connection into an input that was recorded is cut. FMUs that are still connected form one part; a residual
of a part points to its FMUs alone.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Literal, NamedTuple

from fmu_sources.composed import registry
from fmu_sources.composed.composition import all_slots
from fmu_sources.framework.model import Model, Slot
from master import catalogue
from master.coupling.schedule import make_schedule
from master.errors import ConfigError, expected
from master.fmi.description import Description, read_description
from master.fmi.values import parse
from master.system.config import Config, LoadedConfig, load_config
from master.system.graph import System, build_system

from .case import LoadedCase
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
    `instance.variable` that drives it. `compared`: output `instance.variable` to signal.
    """

    fmus: tuple[str, ...]
    inputs: Mapping[str, Mapping[str, MeasuredInput]]
    wired: Mapping[str, Mapping[str, str]]
    compared: Mapping[str, str]

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
    system, sources = _system(config, loaded, progress)
    schedule = make_schedule(system, config.config.coupling.order, config.where("coupling", "order"))
    problems = faults(loaded, system, sources)
    if problems:
        raise ConfigError(problems)
    order = [name for group in schedule.groups for name in group]
    values: Values = {name: dict(i.start) for name, i in system.instances.items()}
    for signal, value in loaded.case.set.items():
        name, _, variable = signal.partition(".")
        values[name][variable] = parse(system.port(signal).variable, value)
    return CutSystem(
        config=config.config,
        folder=config.folder,
        sources=sources,
        values=values,
        descriptions={name: i.description for name, i in system.instances.items()},
        parts=_parts(loaded, system, order),
    )


def _config(loaded: LoadedCase) -> LoadedConfig:
    case = loaded.case
    if case.system is not None:
        return load_config(loaded.document.path.parent / case.system)
    fmus = {name: entry.model_dump() for name, entry in case.fmus.items()}
    config = Config.model_validate({"name": case.name, "stop_time": 1.0, "fmus": fmus})
    return LoadedConfig(config=config, document=loaded.document)


def _system(
    config: LoadedConfig, loaded: LoadedCase, progress: catalogue.Progress
) -> tuple[System, dict[str, str]]:
    problems: list[str] = []
    targets = {}
    entries = config.config.fmus
    for name, entry in entries.items():
        try:
            targets[name] = catalogue.locate(entry.source, config.folder, "native")
        except ConfigError as error:
            problems += [f"{config.where('fmus', name, 'source')}: {p}" for p in error.problems]
    if problems:
        raise ConfigError(problems)
    files = catalogue.files(targets, progress)
    descriptions = {name: read_description(file) for name, file in files.items()}
    overrides = {}
    variant = loaded.case.variant
    if variant is not None:
        if variant not in config.config.variants:
            hint = expected(variant, config.config.variants)
            raise ConfigError([f"{loaded.where('variant')}: no such variant, got {variant!r}, {hint}"])
        for fmu, given in config.config.variants[variant].items():
            for key, value in given.items():
                overrides[f"{fmu}.{key}"] = (config.where("variants", variant, fmu, key), value)
    sources = {name: entry.source for name, entry in entries.items()}
    return build_system(config, descriptions, overrides), sources


def _parts(loaded: LoadedCase, system: System, order: list[str]) -> tuple[CutPart, ...]:
    case = loaded.case
    group = {name: name for name in order}
    wires = [w for w in system.wires if w.target.name not in case.inputs]
    needed = _needed(case.compared, [(w.source.instance, w.target.instance) for w in wires])
    wires = [w for w in wires if w.source.instance in needed and w.target.instance in needed]
    for w in wires:
        old = group[w.target.instance]
        new = group[w.source.instance]
        group = {name: new if g == old else g for name, g in group.items()}
    parts = []
    for first in dict.fromkeys(group[name] for name in order if name in needed):
        members = tuple(name for name in order if group[name] == first and name in needed)
        inputs = {name: _inputs(loaded, system, name) for name in members}
        wired = {
            name: {w.target.variable.name: w.source.name for w in wires if w.target.instance == name}
            for name in members
        }
        compared = {k: s for k, s in case.compared.items() if k.partition(".")[0] in members}
        parts.append(CutPart(members, inputs, wired, compared))
    return tuple(parts)


def _needed(compared: Mapping[str, str], wires: list[tuple[str, str]]) -> set[str]:
    """FMUs that act on something compared."""
    needed = {key.partition(".")[0] for key in compared}
    for _ in wires:
        needed |= {source for source, target in wires if target in needed}
    return needed


def _inputs(loaded: LoadedCase, system: System, name: str) -> Mapping[str, MeasuredInput]:
    """Measured inputs of an FMU by variable."""
    interpolates = "input_hold" in system.instances[name].description.by_name
    inputs: dict[str, MeasuredInput] = {}
    for key, entry in loaded.case.inputs.items():
        fmu, _, variable = key.partition(".")
        if fmu == name:
            inputs[variable] = MeasuredInput(entry.signal, entry.at or ("end" if interpolates else "start"))
    return inputs

"""
Cut a system where signals were measured: each part is replayed alone, on measured inputs.

A connection into an input that was recorded is cut. FMUs that are still connected form one part; a residual
of a part points to its FMUs alone.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
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

from .carriers import Carrier, carried_case, carried_system, carriers_of, hands_on
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
    known. `carriers`: followers at their ports, which the case does not name.
    """

    fmus: tuple[str, ...]
    inputs: Mapping[str, Mapping[str, MeasuredInput]]
    wired: Mapping[str, Mapping[str, str]]
    compared: Mapping[str, str]
    foreign: frozenset[str] = frozenset()
    conversions: Mapping[str, Conversion] = field(default_factory=dict)
    carriers: frozenset[str] = frozenset()

    @property
    def begins_before_its_rows(self) -> bool:
        """Whether the first row may be what a foreign FMU made of an input before the recording."""
        carrying = {SignalName(s).instance for fmu in self.foreign for s in self.wired[fmu].values()}
        return any(
            m.row == "start" for fmu in self.foreign | carrying for m in self.inputs.get(fmu, {}).values()
        )

    @property
    def columns(self) -> list[MeasuredInput]:
        """What drives the part, each once: the columns of a table of inputs."""
        return list(dict.fromkeys(m for inputs in self.inputs.values() for m in inputs.values()))

    @property
    def name(self) -> str:
        """Names of its FMUs."""
        return " and ".join(fmu for fmu in self.fmus if fmu not in self.carriers)


@dataclass(frozen=True)
class CutSystem:
    """
    The system of a case: sources and start values of all FMUs, and the parts that are compared.

    `carriers` are followers at the ports of foreign FMUs, by the names of their instances; `loaded` is the
    case with them in the place of those ports.
    """

    loaded: LoadedCase
    config: Config
    folder: Path
    sources: Mapping[str, str]
    values: Values
    descriptions: Mapping[str, Description]
    parts: tuple[CutPart, ...]
    carriers: Mapping[str, Carrier] = field(default_factory=dict)

    def model(self, fmu: str) -> Model | None:
        """Model that an FMU was built from; None for a foreign file."""
        source = self.sources[fmu]
        return None if catalogue.is_path(source) else registry.load(source)

    def spoken(self, text: str) -> str:
        """Name ports of foreign FMUs where a text names the followers that carry them."""
        for carrier in self.carriers.values():
            text = carrier.spoken(text)
        return text

    def slots(self, fmu: str) -> dict[str, Slot]:
        """Slots of an FMU by name."""
        if fmu in self.carriers:
            return self.carriers[fmu].slots
        model = self.model(fmu)
        return {} if model is None else {s.name: s for s in all_slots(model)}


def cut(loaded: LoadedCase, progress: catalogue.Progress = catalogue.silent) -> CutSystem:
    """
    Read the system of a case and cut it; foreign FMUs get followers at their ports, which have slots.

    Raises:
        ConfigError: With every fault: of the system, or of the names that the case uses in it.
    """
    plain = _joined(loaded, progress)
    carriers = carriers_of(loaded.case, plain.system, plain.foreign)
    if not carriers:
        return plain.cut()
    carried = replace(loaded, case=carried_case(loaded.case, carriers))
    with_followers = carried_system(plain.config.config, carriers, loaded.case, plain.order)
    config = replace(plain.config, config=with_followers)
    system, sources, problems = _system(config, carried, progress)
    if problems:
        raise ConfigError(problems)
    return _Joined(carried, config, system, sources, tuple(carriers)).cut()


@dataclass(frozen=True)
class _Joined:
    """A case and its system, joined and without faults."""

    loaded: LoadedCase
    config: LoadedConfig
    system: System
    sources: Mapping[str, str]
    carriers: tuple[Carrier, ...] = ()

    @property
    def foreign(self) -> list[str]:
        """FMUs of which no model is known."""
        return [name for name, source in self.sources.items() if catalogue.is_path(source)]

    @property
    def order(self) -> list[str]:
        """FMUs in the order in which they step."""
        given = self.config.config.coupling.order
        return make_schedule(self.system, given, self.config.where("coupling", "order")).order

    def cut(self) -> CutSystem:
        """Cut the system where signals were measured."""
        case = self.loaded.case
        system = self.system
        order = self.order
        values: Values = {name: dict(i.start) for name, i in system.instances.items()}
        for signal, value in case.set.items():
            name, variable = SignalName(signal).parts
            values[name][variable] = parse(system.port(signal).variable, value)
        carriers = {c.name: c for c in self.carriers}
        return CutSystem(
            loaded=self.loaded,
            config=self.config.config,
            folder=self.config.folder,
            sources=self.sources,
            values=values,
            descriptions={
                name: carriers[name].described(i.description) if name in carriers else i.description
                for name, i in system.instances.items()
            },
            parts=_parts(self.loaded, system, order, self.foreign, carriers),
            carriers=carriers,
        )


def _joined(loaded: LoadedCase, progress: catalogue.Progress) -> _Joined:
    """
    Read and join the system of a case.

    Raises:
        ConfigError: With every fault.
    """
    config = _config(loaded)
    system, sources, problems = _system(config, loaded, progress)
    problems += faults(loaded, system, sources)
    if not problems:
        problems += _wire_faults(loaded, system)
    if problems:
        raise ConfigError(problems)
    return _Joined(loaded, config, system, sources)


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
    loaded: LoadedCase,
    system: System,
    order: list[str],
    foreign: Collection[str] = (),
    carriers: Collection[str] = (),
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
                carriers=frozenset(carriers) & set(members),
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
    compared += [
        SignalName(w.source.name) for w in system.wires if _is_compared(system, w, compared, foreign)
    ]
    inputs: dict[str, MeasuredInput] = {}
    for key, entry in loaded.case.inputs.items():
        fmu, variable = SignalName(key).parts
        if fmu == name:
            carried = _carried(system, name, variable, foreign)
            row = _row(system, *(carried or (name, variable)), compared)
            inputs[variable] = MeasuredInput(entry.signal, entry.at or row)
    return inputs


def _is_compared(
    system: System, wire: Wire, compared: Sequence[SignalName], foreign: Collection[str]
) -> bool:
    """Whether a wire takes an output of a foreign FMU to what hands it on at once to what is compared."""
    follower = system.instances[wire.target.instance]
    outputs = [signal.variable for signal in compared if signal.instance == wire.target.instance]
    return wire.source.instance in foreign and any(
        hands_on(follower, wire.target.variable.name, output) for output in outputs
    )


def _row(system: System, name: str, variable: str, compared: Sequence[SignalName]) -> Literal["start", "end"]:
    description = system.instances[name].description
    outputs = [signal.variable for signal in compared if signal.instance == name]
    follows = any(description.hands_through(variable, output) for output in outputs)
    return "end" if "input_hold" in description.by_name or follows else "start"


def _carried(system: System, name: str, variable: str, foreign: Collection[str]) -> tuple[str, str] | None:
    """Input of a foreign FMU that an FMU of our own carries one of its inputs to, at once."""
    if name in foreign:
        return None
    for w in system.wires:
        is_from_here = w.source.instance == name and w.target.instance in foreign
        if is_from_here and hands_on(system.instances[name], variable, w.source.variable.name):
            return w.target.instance, w.target.variable.name
    return None

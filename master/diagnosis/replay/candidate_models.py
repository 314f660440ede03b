"""Models with effects as loaded FMUs, each built once; and what a fit may change in them."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from fmu_sources.composed.composition import AND, SEPARATOR
from fmu_sources.effects import catalogue as effects
from fmu_sources.effects.framework.effect import Effect, Rms
from fmu_sources.effects.framework.roles import fits
from fmu_sources.export import build
from fmu_sources.export.native import NativeBuildError
from master import catalogue
from master.diagnosis.case.cut import CutSystem, Part
from master.diagnosis.numerics.least_squares import Parameter
from master.errors import ConfigError
from master.fmi.description import read_description
from master.process.workers import workers
from master.text.signal_name import SignalName

from .replayer import Link, Player

ADVICE = "diagnosis builds models with effects, which needs pip install -e '.[native]'"
LARGEST_SHARE = 1e4


@dataclass(frozen=True, order=True)
class Added:
    """An effect in a slot of an FMU."""

    fmu: str
    slot: str
    effect: str

    @property
    def prefix(self) -> str:
        """Begin of the names of its parameters, behind the FMU's."""
        return f"{self.slot}_{self.effect}"

    @property
    def law(self) -> Effect:
        """The effect itself."""
        return effects.effect(self.effect)

    def __str__(self) -> str:
        return f"{self.fmu}.{self.slot}: {self.effect}"


def source_with(source: str, added: Iterable[Added]) -> str:
    """Name of a model with effects added to its slots."""
    for a in added:
        source += (AND if SEPARATOR in source else SEPARATOR) + a.prefix
    return source


def candidates(system: CutSystem, part: Part, wanted: Mapping[str, str | list[str]]) -> list[Added]:
    """
    List the effects of the library that fit slots of a part.

    Args:
        system: The system.
        part: The part.
        wanted: `fmu.slot` to "all" or names of effects; without any for an FMU, all slots of its equations.
    """
    found = []
    for fmu in part.fmus:
        named = {SignalName(k).variable: v for k, v in wanted.items() if SignalName(k).instance == fmu}
        model, slots = system.model(fmu), system.slots(fmu)
        if not named and model is not None:
            named = {slot.name: "all" for slot in model.slots}
        for slot, names in named.items():
            if slot not in slots:
                raise ConfigError([f"slots.{fmu}.{slot}: no such slot, got it, expected one of {[*slots]}"])
            laws = effects.candidates(slots[slot])
            if names != "all":
                laws = [effects.effect(n) for n in names]
                wrong = [e.name for e in laws if not fits(e, slots[slot])]
                if wrong:
                    raise ConfigError([f"slots.{fmu}.{slot}: effects do not fit, got {wrong}"])
            found += [Added(fmu, slot, e.name) for e in laws]
    return found


class Pool:
    """Loaded chains of one part, by the effects in them."""

    def __init__(self, system: CutSystem, part: Part) -> None:
        self.system, self.part = system, part
        self._players: dict[tuple[Added, ...], Player] = {}

    def build(self, wanted: Sequence[tuple[Added, ...]], progress: Callable[[str], None]) -> None:
        """Build what is missing, on all processors."""
        names = {s for added in wanted for s in self.sources(added).values() if not catalogue.is_path(s)}
        stale = sorted(n for n in names if not build.target(n).is_current())
        if not stale:
            return
        with workers(min(len(stale), os.cpu_count() or 1), "fork") as pool:
            building = [pool.submit(_build, name) for name in stale]
            for name, built in zip(stale, building, strict=True):
                fault = built.result()
                if fault:
                    raise ConfigError([f"{name}.fmu: {fault}; {ADVICE}"])
                progress(name)

    def player(self, added: tuple[Added, ...]) -> Player:
        """Chain with effects, loaded on first use."""
        if added not in self._players:
            self._players[added] = Player(self._links(added))
        return self._players[added]

    def sources(self, added: Sequence[Added]) -> dict[str, str]:
        """Source of each FMU of the part, with effects."""
        return {
            fmu: source_with(self.system.sources[fmu], [a for a in added if a.fmu == fmu])
            for fmu in self.part.fmus
        }

    def close(self) -> None:
        """Unload all."""
        for player in self._players.values():
            player.close()
        self._players = {}

    def _links(self, added: tuple[Added, ...]) -> list[Link]:
        sources = self.sources(added).items()
        targets = {fmu: catalogue.locate(source, self.system.folder, "native") for fmu, source in sources}
        return links(self.system, self.part, catalogue.files(targets, catalogue.silent))


def links(system: CutSystem, part: Part, files: Mapping[str, Path]) -> list[Link]:
    """Chain of a part from FMU files: reads what is compared, what wires need, and the states."""
    columns = list(dict.fromkeys(c for inputs in part.inputs.values() for c in inputs.values()))
    found = []
    for fmu in part.fmus:
        description = read_description(files[fmu])
        needed = [SignalName(k).variable for k in part.compared if SignalName(k).instance == fmu]
        sources = [s for wires in part.wired.values() for s in wires.values()]
        needed += [SignalName(s).variable for s in sources if SignalName(s).instance == fmu]
        model = system.model(fmu)
        if model is not None:
            needed += [n for n in model.continuous.names if n in description.by_name]
        inputs = {v: columns.index(c) for v, c in part.inputs[fmu].items()}
        found.append(Link(fmu, description, inputs, part.wired[fmu], tuple(dict.fromkeys(needed))))
    return found


def _build(name: str) -> str:
    """Build one model; what is wrong, or nothing."""
    try:
        build.build(build.target(name))
    except NativeBuildError as error:
        return str(error)
    return ""


def parameters(added: Added, sizes: Rms, start: Mapping[str, float] | None = None) -> tuple[Parameter, ...]:
    """What a fit changes of an effect, in the names `fmu.variable`."""
    scale = added.law.scale(sizes)
    found = []
    for v in added.law.parameters:
        if v.name not in added.law.fitted:
            continue
        size = scale.get(v.name, 1.0) or 1.0
        low = v.minimum if v.minimum is not None else -float("inf")
        if v.above is not None:
            low = max(v.above, added.law.smallest_share(v.name) * size)
        high = v.maximum if v.maximum is not None else LARGEST_SHARE * size
        at = (start or {}).get(v.name, size)
        name = f"{added.fmu}.{added.prefix}_{v.name}"
        found.append(Parameter(name, at, low, high, abs(size)))
    return tuple(found)


def fixed_values(added: Added, sizes: Rms, variant: Mapping[str, float]) -> dict[str, float]:
    """What a fit leaves alone of an effect, in the names `fmu.variable`."""
    scale = added.law.scale(sizes)
    held = {name: scale[name] for name in added.law.held if name in scale}
    return {f"{added.fmu}.{added.prefix}_{n}": float(v) for n, v in (held | dict(variant)).items()}

"""Models of a part with effects in their slots, each as loaded FMUs, built once."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import replace
from pathlib import Path
from types import TracebackType

from fmu_sources.export import build
from fmu_sources.export.native import NativeBuildError
from master import catalogue
from master.diagnosis.case.cut import CutPart, CutSystem
from master.errors import ConfigError
from master.fmi.description_reader import read_description
from master.fmi.structure import with_structure
from master.process import child
from master.process.workers import each_needed, workers
from master.text.signal_name import SignalName

from .placed_effect import PlacedEffect, source_with
from .replayer import Link, Player


class ModelPool:
    """
    Loaded chains of one part, by the effects in them.

    The FMUs stay loaded until the pool is closed; it is a context manager.
    """

    def __init__(self, system: CutSystem, part: CutPart) -> None:
        self.system = system
        self.part = part
        self._players: dict[tuple[PlacedEffect, ...], Player] = {}
        self._players_with_states: dict[tuple[PlacedEffect, ...], Player] = {}
        self._open = ExitStack()

    def __enter__(self) -> ModelPool:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def build(self, models: Sequence[tuple[PlacedEffect, ...]], progress: Callable[[str], None]) -> None:
        """
        Build what is missing of several models, on all processors where the system can fork.

        Raises:
            ConfigError: If one cannot be built here.
        """
        names = {s for effects in models for s in self.sources(effects).values() if not catalogue.is_path(s)}
        stale = sorted(n for n in names if not build.target(n).is_current())
        if not stale:
            return
        if not child.IS_POSSIBLE:
            for name in stale:
                _raise_if_wrong(name, _build(name))
                progress(name)
            return
        with each_needed(), workers(min(len(stale), os.cpu_count() or 1), "fork") as pool:
            building = [pool.submit(_build, name) for name in stale]
            for name, built in zip(stale, building, strict=True):
                _raise_if_wrong(name, built.result())
                progress(name)

    def player(self, effects: tuple[PlacedEffect, ...]) -> Player:
        """Return the chain with these effects, loaded on first use."""
        if effects not in self._players:
            player = Player(self._links(effects))
            self._open.callback(player.close)
            self._players[effects] = player
        return self._players[effects]

    def player_with_states(self, effects: tuple[PlacedEffect, ...]) -> Player:
        """Return the chain with these effects that reads their states as well, where its FMUs show them."""
        if effects not in self._players_with_states:
            states = [SignalName(e.variable(v.name)) for e in effects for v in e.law.states]
            player = Player([_also_reading(link, states) for link in self._links(effects)])
            self._open.callback(player.close)
            self._players_with_states[effects] = player
        return self._players_with_states[effects]

    def sources(self, effects: Sequence[PlacedEffect]) -> dict[str, str]:
        """Source of each FMU of the part, with effects."""
        return {
            fmu: source_with(self.system.sources[fmu], [e for e in effects if e.fmu == fmu])
            for fmu in self.part.fmus
        }

    def close(self) -> None:
        """Unload all, also where one fails at its end."""
        self._players = {}
        self._players_with_states = {}
        self._open.close()

    def _links(self, effects: tuple[PlacedEffect, ...]) -> list[Link]:
        sources = self.sources(effects).items()
        targets = {fmu: catalogue.locate(source, self.system.folder, "native") for fmu, source in sources}
        return links(self.system, self.part, catalogue.files(targets, catalogue.silent))


def links(system: CutSystem, part: CutPart, files: Mapping[str, Path]) -> list[Link]:
    """Make the chain of a part from FMU files: it reads what is compared, what wires need, and the states."""
    chain = []
    for fmu in part.fmus:
        description = with_structure(read_description(files[fmu]), system.values[fmu])
        compared = [SignalName(key) for key in part.compared]
        sources = [SignalName(source) for wires in part.wired.values() for source in wires.values()]
        read = [signal.variable for signal in (*compared, *sources) if signal.instance == fmu]
        model = system.model(fmu)
        if model is not None:
            read += [n for n in model.continuous.names if n in description.by_name]
        measured = {v: part.columns.index(column) for v, column in part.inputs[fmu].items()}
        conversions = {
            name: part.conversions[f"{fmu}.{name}"]
            for name in part.wired[fmu]
            if f"{fmu}.{name}" in part.conversions
        }
        chain.append(
            Link(
                name=fmu,
                description=description,
                measured=measured,
                wired=part.wired[fmu],
                read=tuple(dict.fromkeys(read)),
                conversions=conversions,
                begins_last=fmu not in part.foreign
                and any(SignalName(s).instance in part.foreign for s in part.wired[fmu].values()),
            )
        )
    return chain


def _also_reading(link: Link, signals: Sequence[SignalName]) -> Link:
    own = [s.variable for s in signals if s.instance == link.name and s.variable in link.description.by_name]
    return replace(link, read=tuple(dict.fromkeys((*link.read, *own))))


def _build(name: str) -> str:
    """Build one model; return what is wrong, or nothing."""
    try:
        build.build(build.target(name))
    except NativeBuildError as error:
        return str(error)
    return ""


def _raise_if_wrong(name: str, fault: str) -> None:
    if fault:
        raise ConfigError([f"{name}.fmu: {fault}"])

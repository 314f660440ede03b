"""
What a diagnosis of a case will cost: processor time, estimated from what is known before it begins.

Loading, judging, pictures and corrected FMUs have constant costs. The search costs as many replays as it
makes, which depends on what is missing and is not known. `seconds` is that of a case in whose longest part
the search goes on for two rounds, `low` where nothing is missing, `high` where it goes on for four. Each
round fits the effects of all rounds so far. All constants are processor seconds of one machine
(docs/diagnosis.md), scaled by a short measurement of this one.
"""

from __future__ import annotations

import math
import os
import time
from collections import Counter
from collections.abc import Collection, Mapping
from contextlib import suppress
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from fmu_sources.composed.composition import AND, SEPARATOR
from fmu_sources.export.places import cache_folder
from fmu_sources.framework.integrate import n_substeps
from master import catalogue
from master.diagnosis.case.case import LoadedCase
from master.diagnosis.case.cut import CutPart, CutSystem
from master.diagnosis.case.split import Split
from master.diagnosis.data.recordings import Recording
from master.diagnosis.replay.fitting_effects import candidates
from master.diagnosis.replay.placed_effect import source_with

LOADING = 4.5  # s
PICTURES = 2.3  # s
PICTURES_OF_CHANNEL = 0.8  # s
JUDGED = 1.5  # s a part
JUDGED_ROW = 0.2e-3  # s a row and channel
CORRECTED = 9.0  # s: an FMU with an effect, for all platforms
BUILT = 2.0  # s: an FMU for this machine
REPLAY = 3.5e-3  # s a recording: initialisation, and what a fit does besides
STEP = 0.3e-6  # s
SUBSTEP = 0.1e-6  # s an FMU that integrates
SCREENED = 0.02  # s an effect
SCREENED_STEP = 9e-6  # s an effect and step
MOST_FITS = 10  # of a round
PASSES = 15  # replays of all that is fitted, a parameter and fit
OWN_PARAMETERS = 2  # of an effect, about
FITTED_ROW = 0.8e-6  # s a row, channel and pass of a fit: residual, derivatives, decomposition
AGAIN = 2.0  # a round's fits are made once more: earlier effects, laws in their place, each effect left out
ROUNDS = 2.0  # between one effect and a search to its end
ROUNDS_OF_ALL = 4.0
PASSES_OF_BASE = 80
PAIRS = 0.6  # of the effects in one place: models of two that a second round builds
FEW_PAIRS = 8  # in the cache: more are of an earlier diagnosis
MOST_BUILT = 15  # models with one effect
REFERENCE = 2.9e-3  # s: `speed_probe` on the machine of the constants


@dataclass(frozen=True)
class PartCost:
    """
    Quantities that decide the cost of one part.

    `rows` that are fitted or selected by, `steps` of a replay of all that is fitted, `substeps` of all of
    them in all FMUs that integrate, `parameters` that are refitted, `effects` to consider, `built`: models
    with one effect that are not in the cache, `missing_pairs`: those with two of a second round.
    """

    name: str
    channels: int
    rows: int
    recordings: int
    steps: int
    substeps: int
    parameters: int
    effects: int
    built: int
    missing_pairs: float
    is_software: bool

    @property
    def replay(self) -> float:
        """Time of a replay of all that is fitted [s]."""
        return self.recordings * REPLAY + self.steps * STEP + self.substeps * SUBSTEP

    @property
    def screened(self) -> float:
        """Time in which one effect is screened [s]."""
        return SCREENED + SCREENED_STEP * self.steps

    @property
    def judged(self) -> float:
        """Time in which the base is fitted and what it leaves is judged [s]."""
        judged = 0.0 if self.is_software else JUDGED + JUDGED_ROW * self.rows * self.channels
        return PASSES_OF_BASE * self.replay + judged

    def search(self, rounds: float) -> float:
        """Time of some rounds of a search [s]; software is not searched for effects."""
        if self.is_software:
            return 0.0
        fits = min(self.effects, MOST_FITS)
        own = OWN_PARAMETERS * rounds * (rounds + 1.0) / 2.0  # one effect's more in each round
        passes = AGAIN * fits * PASSES * (rounds * self.parameters + own)
        one_pass = self.replay + FITTED_ROW * self.rows * self.channels
        return passes * one_pass + rounds * self.effects * self.screened

    @property
    def to_build(self) -> float:
        """Models that a search of two rounds builds."""
        if self.is_software:
            return 0.0
        return min(self.built, MOST_BUILT) + self.missing_pairs


@dataclass(frozen=True)
class Cost:
    """Processor time of a diagnosis [s] on a machine of some `speed` over that of the constants."""

    parts: tuple[PartCost, ...]
    speed: float

    @property
    def seconds(self) -> float:
        """Of a case in whose longest part the search goes on for two rounds."""
        longest = max((p.search(ROUNDS) + BUILT * p.to_build for p in self.parts), default=0.0)
        return (self._known + CORRECTED + longest) / self.speed

    @property
    def low(self) -> float:
        """Of a case that lacks nothing."""
        return self._known / self.speed

    @property
    def high(self) -> float:
        """Of a case in whose longest part the search goes on to its end."""
        longest = max(
            (p.search(ROUNDS_OF_ALL) + ROUNDS_OF_ALL / 2.0 * BUILT * p.to_build for p in self.parts),
            default=0.0,
        )
        return (self._known + CORRECTED + longest) / self.speed

    @property
    def _known(self) -> float:
        channels = sum(p.channels for p in self.parts)
        pictures = PICTURES + PICTURES_OF_CHANNEL * channels
        return LOADING + pictures + sum(p.judged for p in self.parts)

    def as_dict(self) -> dict[str, Any]:
        """Return what `check --json` says of it: processor seconds, and what they were made of."""
        return {
            "seconds": float(f"{self.seconds:.3g}"),
            "low": float(f"{self.low:.3g}"),
            "high": float(f"{self.high:.3g}"),
            "speed": float(f"{self.speed:.3g}"),
            "parts": [asdict(part) for part in self.parts],
        }

    def __str__(self) -> str:
        effects = sum(p.effects for p in self.parts)
        built = round(max((p.to_build for p in self.parts), default=0.0))
        parts = f"{len(self.parts)} part{'s' if len(self.parts) != 1 else ''}"
        steps = sum(p.steps for p in self.parts)
        substeps = sum(p.substeps for p in self.parts)
        return (
            f"a diagnosis takes about {_rounded(self.seconds)} of processor time ({_rounded(self.low)} if "
            f"nothing is missing, {_rounded(self.high)} or more if the search goes on): "
            f"{effects} effects in {parts}, {steps} steps and {substeps} substeps a replay, some {built} "
            "models to build"
        )


def cost_of(loaded: LoadedCase, system: CutSystem, recordings: Mapping[str, Recording], split: Split) -> Cost:
    """Estimate the cost of a diagnosis from a case, its cut system, its recordings and its split."""
    names = _built_names()
    parts = [_part(loaded, system, part, recordings, split, names) for part in system.parts]
    return Cost(tuple(parts), REFERENCE / speed_probe())


def speed_probe() -> float:
    """Processor time [s] of a little fixed work, in Python and in NumPy, the least of eight."""
    values = np.linspace(0.0, 1.0, 20_000)
    found = math.inf
    for _ in range(8):
        begin = time.process_time()
        total = 0.0
        for i in range(20_000):
            total += i * 0.5
        for _ in range(5):
            np.sort(np.sin(values * total))
        found = min(found, time.process_time() - begin)
    return max(found, 1e-6)


def _part(
    loaded: LoadedCase,
    system: CutSystem,
    part: CutPart,
    recordings: Mapping[str, Recording],
    split: Split,
    names: Collection[str],
) -> PartCost:
    replay = loaded.case.replay
    fitted = list(dict.fromkeys(s.recording for s in split.fit))
    steps = sum(len(recordings[name]) for name in fitted) * replay.oversample
    period = next(iter(recordings.values())).period / replay.oversample
    models = [model for model in map(system.model, part.fmus) if model is not None]
    substeps = sum(n_substeps(period, m.substep) for m in models if m.n_continuous)
    effects = candidates(system, part, loaded.case.slots)
    with_one = [source_with(system.sources[e.fmu], [e]) for e in effects]
    bases = {system.sources[fmu] for fmu in part.fmus if not catalogue.is_path(system.sources[fmu])}
    pairs = [n for n in names if AND in n and n.partition(SEPARATOR)[0] in bases]
    refitted = [key for key in loaded.case.refit if key.partition(".")[0] in part.fmus]
    own = sum(key in loaded.case.per_recording for key in refitted)
    rows = sum(len(s) for s in (*split.fit, *split.select))
    return PartCost(
        name=part.name,
        channels=len(part.compared),
        rows=rows,
        recordings=len(fitted),
        steps=steps,
        substeps=steps * substeps,
        parameters=len(refitted) + own * (len(fitted) - 1),
        effects=len(effects),
        built=sum(name not in names for name in with_one),
        missing_pairs=PAIRS * max(Counter(e.place for e in effects).values(), default=0)
        if len(pairs) < FEW_PAIRS
        else 0.0,
        is_software=len(models) == len(part.fmus)
        and all(m.n_continuous == 0 and m.sample_time is not None for m in models),
    )


def _built_names() -> frozenset[str]:
    """Names of the native FMUs in the cache: one may be older than its sources, which is not looked into."""
    found: set[str] = set()
    with suppress(OSError), os.scandir(cache_folder() / "fmus" / "native") as tokens:  # there may be none
        for token in tokens:
            with suppress(OSError):  # another process may just have removed it
                found |= {name.removesuffix(".fmu") for name in os.listdir(token.path)}
    return frozenset(found)


def _rounded(seconds: float) -> str:
    """Two digits, in seconds or minutes."""
    return f"{seconds:.2g} s" if seconds < 99.5 else f"{seconds / 60.0:.2g} min"

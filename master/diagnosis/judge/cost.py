"""
What a diagnosis of a case will cost: processor time, estimated from what is known before it begins.

Loading, judging, pictures and corrected FMUs have constant costs. The search costs as many replays as it
makes, which depends on what is missing and is not known. `seconds` is that of a case in whose longest part
the search goes on for two rounds, `low` where nothing is missing, `high` where it goes on for four. Each
round fits the effects of all rounds so far, and builds what of its models is not in the cache. All constants
are processor seconds of one machine (docs/diagnosis.md), scaled by a short measurement of this one.
"""

from __future__ import annotations

import math
import time
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from fmu_sources.composed import registry
from fmu_sources.export import build
from fmu_sources.framework.integrate import n_substeps
from master.diagnosis.case.case import LoadedCase
from master.diagnosis.case.cut import CutPart, CutSystem
from master.diagnosis.case.split import Split
from master.diagnosis.data.recordings import Recording
from master.diagnosis.replay.fitting_effects import candidates
from master.diagnosis.replay.placed_effect import source_with

LOADING = 3.5  # s
PICTURES = 1.4  # s
PICTURES_OF_CHANNEL = 0.45  # s
JUDGED = 0.8  # s a part
JUDGED_ROW = 0.1e-3  # s a row and channel
CORRECTED = 9.0  # s: an FMU with an effect, for all platforms
BUILT = 1.8  # s: an FMU for this machine
REPLAY = 0.8e-3  # s a recording: initialisation, and what a fit does besides
STEP = 0.21e-6  # s
SUBSTEP = 0.07e-6  # s an FMU that integrates
SCREENED = 0.01  # s an effect
SCREENED_STEP = 4e-6  # s an effect and step
MOST_FITS = 8  # of a round
PASSES = 28  # replays of all that is fitted, a parameter and fit
OWN_PARAMETERS = 2  # of an effect, about
FITTED_ROW = 0.05e-6  # s a row, channel and pass of a fit: residual, derivatives, decomposition
AGAIN = 1.5  # of later rounds: earlier effects, laws in several places, each effect left out
WITH_MEMORY = 0.5  # of the fits of later rounds
ROUNDS = 2  # between one effect and a search to its end
ROUNDS_OF_ALL = 4
PASSES_OF_BASE = 80
FIRST_BUILT = 10  # models with one effect that are built: what is fitted
LATER_BUILT = 30  # a later round
MOST_ASKED = 10  # models that the cache is asked for: the others are taken to be there alike
REFERENCE = 2.9e-3  # s: `speed_probe` on the machine of the constants


@dataclass(frozen=True)
class PartCost:
    """
    Quantities that decide the cost of one part.

    `rows` that are fitted or selected by, `steps` of a replay of all that is fitted, `substeps` of all of
    them in all FMUs that integrate, `parameters` and start values that are fitted, `effects` to consider,
    `substeps_of_memory` are those of all steps in an FMU that integrates as soon as a law in it has a memory,
    `missing`: share of the models that a search builds which an earlier diagnosis has not left in the cache.
    """

    name: str
    channels: int
    rows: int
    recordings: int
    steps: int
    substeps: int
    substeps_of_memory: int
    parameters: int
    effects: int
    missing: float
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
        return PASSES_OF_BASE * self.replay + self.judged_again

    @property
    def judged_again(self) -> float:
        """Time in which what a model leaves is judged [s]."""
        return 0.0 if self.is_software else JUDGED + JUDGED_ROW * self.rows * self.channels

    def search(self, rounds: int) -> float:
        """Time of some rounds of a search and of the models that it builds [s]; software is not searched."""
        if self.is_software or not rounds:
            return 0.0
        first = self.replay + FITTED_ROW * self.rows * self.channels
        later = AGAIN * (first + WITH_MEMORY * self.substeps_of_memory * SUBSTEP)
        fits = min(self.effects, MOST_FITS)
        found = self.judged_again + rounds * self.effects * self.screened + BUILT * self.to_build(rounds)
        for n_effects in range(1, rounds + 1):
            own = self.parameters + n_effects * OWN_PARAMETERS
            found += fits * PASSES * own * (first if n_effects == 1 else later)
        return found

    def to_build(self, rounds: int) -> float:
        """Models that some rounds build."""
        if self.is_software or not rounds:
            return 0.0
        first = min(self.effects, FIRST_BUILT)
        return self.missing * (first + (rounds - 1) * min(self.effects, LATER_BUILT))


@dataclass(frozen=True)
class Cost:
    """Processor time of a diagnosis [s] on a machine of some `speed` over that of the constants."""

    parts: tuple[PartCost, ...]
    speed: float

    @property
    def seconds(self) -> float:
        """Of a case in whose longest part the search goes on for two rounds."""
        return self._after(ROUNDS)

    @property
    def low(self) -> float:
        """Of a case that lacks nothing."""
        return self._known / self.speed

    @property
    def high(self) -> float:
        """Of a case in whose longest part the search goes on to its end."""
        return self._after(ROUNDS_OF_ALL)

    def _after(self, rounds: int) -> float:
        longest = max((p.search(rounds) for p in self.parts), default=0.0)
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
        built = round(max((p.to_build(ROUNDS) for p in self.parts), default=0.0))
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
    parts = [_part(loaded, system, part, recordings, split) for part in system.parts]
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
) -> PartCost:
    replay = loaded.case.replay
    fitted = list(dict.fromkeys(s.recording for s in split.fit))
    steps = sum(len(recordings[name]) for name in fitted) * replay.oversample
    period = next(iter(recordings.values())).period / replay.oversample
    models = [model for model in map(system.model, part.fmus) if model is not None]
    substeps = sum(n_substeps(period, m.substep) for m in models if m.n_continuous)
    static = [m for m in models if not m.n_continuous and m.sample_time is None]
    memory = max((n_substeps(period, m.substep) for m in static), default=0)
    effects = candidates(system, part, loaded.case.slots)
    refitted = [key for key in loaded.case.refit if key.partition(".")[0] in part.fmus]
    own = sum(key in loaded.case.per_recording for key in refitted)
    is_whole = len(fitted) == 1 and not any(fmu in replay.windows for fmu in part.fmus)
    starts = [key for key in loaded.case.starts if key.partition(".")[0] in part.fmus] if is_whole else []
    rows = sum(len(s) for s in (*split.fit, *split.select))
    return PartCost(
        name=part.name,
        channels=len(part.compared),
        rows=rows,
        recordings=len(fitted),
        steps=steps,
        substeps=steps * substeps,
        substeps_of_memory=steps * memory,
        parameters=len(refitted) + own * (len(fitted) - 1) + len(starts),
        effects=len(effects),
        missing=_missing([source_with(system.sources[e.fmu], [e]) for e in effects]),
        is_software=len(models) == len(part.fmus)
        and all(m.n_continuous == 0 and m.sample_time is not None for m in models),
    )


def _missing(names: Sequence[str]) -> float:
    """
    Share of the models that a search builds which is not in the cache, by those with one effect.

    A diagnosis builds those that it fits: as many in the cache are all. Some are asked for; of a model of
    one's own none, as its sources have to be generated for that: it counts as missing.
    """
    asked = [names[i * len(names) // MOST_ASKED] for i in range(min(len(names), MOST_ASKED))]
    asked = asked if len(names) > MOST_ASKED else list(names)
    current = sum(not registry.is_own(name) and build.target(name).is_current() for name in asked)
    there = len(names) * current / max(len(asked), 1)
    return max(0.0, 1.0 - there / max(min(len(names), FIRST_BUILT), 1))


def _rounded(seconds: float) -> str:
    """Two digits, in seconds or minutes."""
    return f"{seconds:.2g} s" if seconds < 99.5 else f"{seconds / 60.0:.2g} min"

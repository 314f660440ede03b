"""One part under study: rows to fit on and to select by, the base, and models with effects as candidates."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np

from fmu_sources.effects.framework.effect import Rms
from master.diagnosis.case.case import Case
from master.diagnosis.case.cut import CutSystem, Values
from master.diagnosis.numerics.arrays import TINY, Array, Mask
from master.diagnosis.numerics.gains import Gain, gain_over, powers
from master.diagnosis.numerics.least_squares import Candidate, Fit, FreeParameter, fit
from master.diagnosis.replay.candidate_models import ModelPool
from master.diagnosis.replay.own_values import own_name
from master.diagnosis.replay.placed_effect import PlacedEffect
from master.diagnosis.replay.replay_bench import ReplayBench
from master.diagnosis.replay.slot_signals import Signals, signal_rms, slot_signals
from master.errors import FmuError
from master.text.signal_name import SignalName

from .extended_model import ExtendedModel

Progress = Callable[[str], None]

EXACT = 3e-5  # over the deviation of what was measured: what rounding leaves
FACTORS_OF_START = (0.85, 1.2)  # first guesses of the base's parameters, over the system's values
START_OF_STATE = 0.25  # scale of a start value over the distance of its bounds


class Precision(NamedTuple):
    """Where a fit ends: residual evaluations from each start, and relative change of the cost."""

    evaluations: int
    tolerance: float


FIRST_STEPS = Precision(4, 1e-5)  # of several first guesses, to see which goes on
QUICK = Precision(25, 1e-5)  # to rank effects
FINE = Precision(30, 1e-8)  # for a choice between two laws
PRECISE = Precision(60, 1e-8)  # what a coarser fit leaves would pass for another effect
OF_BASE = Precision(30, 1e-9)
OF_ANSWER = Precision(20, 1e-9)  # starts at a fit already


@dataclass(frozen=True)
class Study:
    """
    What the search needs of a part.

    `base` are the parameters of the system that may be refitted. `fit_rows` has shape (rows,), `held_out` are
    the blocks to select by. `output_scale`, shape (outputs,), is what the outputs' errors are compared with.
    `slot_values` are values by `fmu.variable` of the base along whose replay the slots are looked into.
    """

    system: CutSystem
    bench: ReplayBench
    pool: ModelPool
    base: tuple[FreeParameter, ...]
    fit_rows: Mask
    held_out: tuple[slice, ...]
    progress: Progress
    output_scale: Array
    slot_values: Mapping[str, float]

    @property
    def name(self) -> str:
        """Name of the part."""
        return self.bench.name

    @property
    def measured(self) -> Array:
        """Measured outputs, shape (rows, outputs)."""
        return self.bench.measured

    @cached_property
    def signals(self) -> Signals:
        """What is in the slots along a replay of the base."""
        return slot_signals(self.system, self.bench, self.pool.player(()), self.values_with(self.slot_values))

    def say(self, text: str) -> None:
        """Show what is being done on this part."""
        self.progress(f"{self.name}: {text}")

    def build(self, models: Sequence[tuple[PlacedEffect, ...]]) -> None:
        """Build what is missing of several models; ConfigError if one cannot be built."""
        self.pool.build(models, self.progress)

    def values_with(self, values: Mapping[str, float]) -> Values:
        """Return values of the system with others, by `fmu.variable`, in their place."""
        return merged(self.system.values, values)

    def slot_signals_with(
        self, model: ExtendedModel, values: Mapping[str, float], place: str
    ) -> Mapping[str, Array]:
        """Signals of one slot `fmu.slot` along a replay of a model with effects."""
        fmu = SignalName(place).instance
        player = self.pool.player(model.effects)
        return slot_signals(self.system, self.bench, player, self.values_with(values), (fmu,))[place]

    def simulate(
        self, effects: tuple[PlacedEffect, ...], values: Mapping[str, float], *, everything: bool = False
    ) -> Array:
        """Replay with effects and values by `fmu.variable`; see `ReplayBench.predict`."""
        player = self.pool.player(effects)
        return self.bench.predict(player, self.values_with(values), everything=everything)

    def outputs(self, effects: tuple[PlacedEffect, ...], values: Mapping[str, float]) -> dict[str, Array]:
        """The same at all samples by recording; see `ReplayBench.replayed`."""
        return self.bench.replayed(self.pool.player(effects), self.values_with(values))

    def replayed_with_noise(
        self, values: Mapping[str, float], deviations: Sequence[float], n_draws: int
    ) -> Array:
        """
        Changes of the base's prediction under white noise on what drives the part.

        Args:
            values: Of the base, by `fmu.variable`.
            deviations: Of the noise on each measured input, in the order of the part's columns.
            n_draws: Number of replays.

        Returns:
            Shape (draws, rows, outputs).
        """
        player = self.pool.player(())
        given = self.values_with(values)
        quiet = self.bench.predict(player, given)
        return np.stack(
            [
                self.bench.with_noise(deviations, seed).predict(player, given) - quiet
                for seed in range(1, n_draws + 1)
            ]
        )

    def candidate(
        self,
        model: ExtendedModel,
        starts: Sequence[Mapping[str, float]] = ({},),
        known: Mapping[str, Array] | None = None,
    ) -> Candidate:
        """Base and effects as one model to fit; `known` sensitivities see `Candidate`."""
        parameters = (*self.base, *model.parameters)
        names = [p.name for p in parameters]

        def simulate(theta: Array) -> Array:
            values = dict(model.fixed) | dict(zip(names, theta.tolist(), strict=True))
            return self.simulate(model.effects, values)

        return Candidate(model.name, parameters, simulate, tuple(starts), known or {})

    def fitted(
        self,
        model: ExtendedModel,
        starts: Sequence[Mapping[str, float]] = ({},),
        precision: Precision = QUICK,
        known: Mapping[str, Array] | None = None,
    ) -> Fit:
        """Fit base and effects together; of several first guesses the best after a few steps goes on."""
        model, starts = self._with_start_values(model, starts)
        if len(starts) > 1:
            first = Precision(FIRST_STEPS.evaluations, precision.tolerance)
            begun = [
                self._fit(self.candidate(model, [guess], known), first, is_sketch=True) for guess in starts
            ]
            starts = [min(begun, key=lambda f: f.cost).values]
        best = self._fit(self.candidate(model, starts, known), precision)
        values = dict(model.fixed) | dict(best.values)
        return replace(best, predicted=self.simulate(model.effects, values, everything=True))

    def _fit(self, candidate: Candidate, precision: Precision, *, is_sketch: bool = False) -> Fit:
        return fit(
            candidate,
            self.measured,
            self.fit_rows,
            output_scale=self.output_scale,
            evaluations=precision.evaluations,
            tolerance=precision.tolerance,
            is_sketch=is_sketch,
        )

    def _with_start_values(
        self, model: ExtendedModel, starts: Sequence[Mapping[str, float]]
    ) -> tuple[ExtendedModel, list[Mapping[str, float]]]:
        """Let the fit find start values of states too, from an estimate at each first guess."""
        player = self.pool.player(model.effects)
        bounds = {key: self.bench.starts[key] for key in self.bench.starts_of(player)}
        if not bounds:
            return model, list(starts)
        known = {p.name: p.start for p in (*self.base, *model.parameters)} | dict(model.fixed)
        better: list[Mapping[str, float]] = []
        for guess in starts:
            here = {k: v for k, v in guess.items() if k in known}
            values = self.values_with(known | here)
            for key in bounds:
                values[SignalName(key).instance].pop(SignalName(key).variable, None)
            better.append(dict(guess) | self.bench.estimated(player, values))
        taken = {p.name for p in model.parameters}
        own = tuple(
            FreeParameter(key, 0.5 * (low + high), low, high, START_OF_STATE * (high - low))
            for key, (low, high) in bounds.items()
            if key not in taken
        )
        return replace(model, parameters=(*model.parameters, *own)), better

    @property
    def is_exact(self) -> bool:
        """Whether what the base leaves is rounding."""
        deviation = self.measured[self.fit_rows].std(axis=0)
        return bool(np.all(self.output_scale < EXACT * np.maximum(deviation, TINY)))

    def nominal(self) -> Fit:
        """The base at the values of the system, as a fit."""
        values = {p.name: p.start for p in self.base}
        predicted = self.simulate((), values, everything=True)
        return Fit("system", values, dict.fromkeys(values, 0.0), predicted, np.inf)

    def gain(self, before: Fit, after: Fit) -> Gain:
        """Gain of one fit over another on the held-out blocks."""
        return gain_over(before, after, self.measured, self.held_out, self.output_scale)

    def powers(self, predicted: Array) -> Array:
        """Power in each held-out block of what a prediction (rows, outputs) leaves, shape (blocks,)."""
        return powers(predicted - self.measured, self.held_out, self.output_scale)

    def signal_rms(self, place: str) -> Rms:
        """Sizes of the signals of a slot; a force that is zero is measured by the largest of its FMU."""
        rms = signal_rms(self.signals[place], len(self.measured) * self.bench.row_period)
        if np.any(self.signals[place]["value"]):
            return rms
        fmu = SignalName(place).instance + "."
        own = [s for key, s in self.signals.items() if key.startswith(fmu) and np.any(s["value"])]
        others = [signal_rms(s, 1.0).value for s in own]
        mechanical = [signal_rms(s, 1.0).value for s in own if "velocity" in s]
        return replace(rms, value=max(mechanical or others or [1.0]))


class Begun(NamedTuple):
    """A study whose outputs are scaled by what the refitted base leaves, and that base."""

    study: Study
    base: Fit


def begin(
    system: CutSystem,
    bench: ReplayBench,
    pool: ModelPool,
    base: tuple[FreeParameter, ...],
    fit_rows: Mask,
    held_out: Sequence[slice],
    progress: Progress,
) -> Begun:
    """
    Fit the base, first scaled by what was measured, then by what that leaves.

    Raises:
        FmuError: If an FMU cannot be replayed on what was measured.
    """
    measured = bench.measured
    deviation = measured[fit_rows].std(axis=0)
    first_study = Study(
        system=system,
        bench=bench,
        pool=pool,
        base=base,
        fit_rows=fit_rows,
        held_out=tuple(held_out),
        progress=progress,
        output_scale=np.where(deviation > 0.0, deviation, 1.0),
        slot_values={p.name: p.start for p in base},
    )
    others = [{p.name: factor * p.start for p in base} for factor in FACTORS_OF_START] if base else []
    precision = Precision(OF_BASE.evaluations, QUICK.tolerance)
    first = first_study.fitted(ExtendedModel(), [{}, *others], precision)
    if not np.isfinite(first.predicted[bench.in_use]).all():
        failure = bench.failure(pool.player(()), first_study.values_with(first.values))
        row = int(np.flatnonzero(~np.isfinite(first.predicted).all(axis=1))[0])
        if failure is None:
            raise FmuError(bench.part.fmus[0], f"the replay is not finite at row {row}")
        raise FmuError(failure.instance, f"the replay ends at row {row}: {failure}", status=failure.status)
    left = np.sqrt(np.nanmean((first.predicted - measured)[fit_rows] ** 2, axis=0))
    scaled = replace(
        first_study,
        output_scale=np.maximum(left, 1e-9 * first_study.output_scale),
        base=tuple(replace(p, scale=abs(first.values[p.name]) or p.scale) for p in base),
    )
    refitted = scaled.fitted(ExtendedModel(), [first.values], OF_BASE)
    return Begun(replace(scaled, slot_values=refitted.values), refitted)


def base_parameters(
    case: Case, system: CutSystem, fmus: Sequence[str], recordings: Sequence[str] = ()
) -> tuple[FreeParameter, ...]:
    """
    Parameters that the case allows to refit, from the values of the system.

    Those that every recording has for itself are there once for each of the `recordings` that a fit sees.
    """
    parameters = []
    for key, entry in case.refit.items():
        fmu, variable = SignalName(key).parts
        if fmu in fmus:
            value = system.values[fmu].get(variable, system.descriptions[fmu].by_name[variable].start or 0.0)
            at = float(min(max(float(value), entry.low), entry.high))
            scale = abs(at) or 0.1 * (entry.high - entry.low)
            names = [key]
            if key in case.per_recording:
                names = [own_name(key, r) for r in recordings if key not in case.recordings[r].set]
            parameters += [
                FreeParameter(name, at, entry.low, entry.high, scale, entry.spread) for name in names
            ]
    return tuple(parameters)


def merged(values: Values, given: Mapping[str, float]) -> Values:
    """Return values by FMU with others, by `fmu.variable`, in their place."""
    result = {name: dict(v) for name, v in values.items()}
    for key, value in given.items():
        fmu, variable = SignalName(key).parts
        result[fmu][variable] = value
    return result

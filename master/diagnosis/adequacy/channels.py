"""
Adequacy of a model on one compared channel: what is left in units of the noise floor, and what predicts it.

A name is worth something only where it has taken the residual down to what the channel cannot tell apart.
So after every stage two numbers are asked for: the rms that is left over the noise floor, and the share
of its power that a regression without physics predicts on blocks that it has not seen.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from enum import Enum
from functools import cached_property

import numpy as np
from threadpoolctl import threadpool_limits

from master.diagnosis.numerics.arrays import TINY, Array, Integers, Mask
from master.diagnosis.numerics.evenness import chance_of_unevenness
from master.diagnosis.numerics.folds import NO_SHARE, Folds, Share, share_of
from master.diagnosis.numerics.noise_floor import (
    Colour,
    NoiseFloor,
    colour_of,
    from_differences,
    noise_floor,
    step_of,
)
from master.diagnosis.numerics.regressors import HeldOut, line, line_over, ridge, trees, without_mains
from master.diagnosis.numerics.strikes import events, strikes
from master.diagnosis.search.extended_model import ExtendedModel
from master.diagnosis.search.study import Study
from master.diagnosis.unnamed_law.fit import sensitivities

from .recorded import Recorded
from .slot_laws import SlotLaw, SlotLaws

GUARD = 0.1  # s between what is fitted on and what is predicted
GUARD_ROWS = 5  # at least
N_STRETCHES = 4  # one after the other: a wave of coloured noise does not last from one to the next
PREDICTABLE = 0.05  # share from which on something recorded predicts the residual
PREDICTABLE_HIGH = 0.10  # upper end of its interval, from which on it may
ROUNDING = (
    1e-12  # of the deviation of what was measured: what is left below it is arithmetic, and counts as nothing
)
WITHIN_FLOOR = 1.3  # rms over the noise floor, up to which nothing but noise is left
MANY_FLOORS = 3.5  # rms over the noise floor, that no nuisance makes
UNEVEN = 1e-4  # probability that noise, of whatever colour, is as uneven in time
HIGHEST = 0.06  # of the sampling rate: frequency of a line
MOST_LINES = 8  # signals that may be modulated
DRAWS = 3  # replays with noise on what drives the part
FEWEST_ROWS = 5  # of a window
LONGEST_EVENT = 0.05  # s, of a window in which power is counted
AVERAGED = (0.01, 0.02)  # s, before it is asked what its past does not predict: the quick, then the slow


class Kind(Enum):
    """What a regressor finds."""

    LINEAR = "linear dynamics of what was recorded"
    TREES = "thresholds, codes or memory"
    MODULATED = "periodic in time"
    PERIODIC = "periodic over a signal"
    LAW = "a law of the slot's signals"


@dataclass(frozen=True)
class Predictor:
    """
    One regressor's share of a residual on held-out rows.

    `of` names its signal, or the law of a slot; `frequency` is that of a line, per second or per unit of the
    signal.
    """

    kind: Kind
    of: str
    share: Share
    law: SlotLaw | None = None
    frequency: float = 0.0

    def __str__(self) -> str:
        if self.kind is Kind.MODULATED:
            return f"periodic in time at {self.frequency:.4g} Hz, times {self.of}"
        if self.kind is Kind.PERIODIC:
            return f"periodic over {self.of} with {1.0 / max(self.frequency, TINY):.4g}"
        return f"{self.kind.value}: {self.of}" if self.of else self.kind.value


@dataclass(frozen=True)
class Adequacy:
    """
    What a model leaves of one channel.

    `rms` is left; `floor` is the channel's own, `passed` the noise of what drives the part, passed through
    the model, both in the channel's unit. `predictors` are all regressors, the best first. `events` are the
    times [s] of windows that hold most of the power, where few do; `strikes` those of windows that set off
    what rings on, where more is left than noise makes. `has_steps`: the channel or what drives it is rounded
    to the steps of a converter. `chance` is the probability that noise is as uneven in time as what is left.
    """

    signal: str
    rms: float
    floor: NoiseFloor
    passed: float
    predictors: tuple[Predictor, ...]
    colour: Colour
    events: tuple[float, ...] = ()
    strikes: tuple[float, ...] = ()
    has_steps: bool = False
    chance: float = 1.0

    @property
    def noise(self) -> float:
        """Floor of the comparison: the channel's own and what the inputs' noise makes."""
        return float(np.hypot(self.floor.value, self.passed))

    @property
    def ratio(self) -> float:
        """What is left over the noise floor."""
        return self.rms / max(self.noise, TINY)

    @property
    def best(self) -> Predictor | None:
        """
        The regressor that predicts most; None where nothing was recorded that moves.

        Rounding of what was recorded repeats over the signals: within the floor it is no finding.
        """
        is_rounding = self.has_steps and self.is_within_floor
        telling = (p for p in self.predictors if not (is_rounding and p.kind is Kind.PERIODIC))
        return next(telling, None)

    @property
    def share(self) -> Share:
        """Predictable share."""
        return self.best.share if self.best is not None else NO_SHARE

    @property
    def is_predictable(self) -> bool:
        """Whether something recorded still predicts what is left."""
        sure = self.share.interval.low > 0.0
        return (self.share.value >= PREDICTABLE and sure) or self.share.interval.low >= PREDICTABLE

    @property
    def is_silent(self) -> bool:
        """Whether nothing recorded predicts it, beyond doubt."""
        return self.share.value < PREDICTABLE and self.share.interval.high < PREDICTABLE_HIGH

    @property
    def is_within_floor(self) -> bool:
        """Whether hardly more is left than the noise of the channel."""
        return self.ratio < WITHIN_FLOOR

    @property
    def is_unpredicted(self) -> bool:
        """Whether no regressor predicts it, those that see the rounding of a converter included."""
        return all(p.share.value < PREDICTABLE for p in self.predictors)

    @property
    def is_uneven(self) -> bool:
        """Whether what is left is above the floor, and less even in time than noise of any colour."""
        return not self.is_within_floor and self.chance < UNEVEN

    @property
    def is_above_floor(self) -> bool:
        """Whether more is left than noise of any colour makes."""
        return self.ratio > MANY_FLOORS or bool(self.events) or self.is_uneven

    @property
    def is_adequate(self) -> bool:
        """Whether the model explains the channel as far as the channel can tell."""
        return self.is_silent and not self.is_above_floor


@dataclass(frozen=True)
class Judge:
    """Adequacy of models of one part on its open rows; what was recorded is laid out once."""

    study: Study
    base_values: Mapping[str, float]
    base_predicted: Array

    @cached_property
    def rows(self) -> Mask:
        """Rows to judge on: those to fit on and to select by, once the replay has settled."""
        rows = self.study.fit_rows.copy()
        for block in self.study.held_out:
            rows[block] = True
        return np.asarray(rows & self.study.bench.in_use)

    @cached_property
    def folds(self) -> Folds:
        """Blocks of those rows."""
        guard = max(GUARD_ROWS, round(GUARD / self.study.bench.row_period))
        return Folds.of(self.rows, guard)

    @cached_property
    def long_folds(self) -> Folds:
        """Long stretches of those rows: short blocks between others do not tell a law from a slow wave."""
        return Folds.of(self.rows, self.folds.guard, N_STRETCHES)

    @cached_property
    def recorded(self) -> Recorded:
        """Everything recorded."""
        return Recorded(self.study)

    @cached_property
    def laws(self) -> dict[SlotLaw, Array]:
        """Splines of the slots' signals, passed through the model."""
        return SlotLaws(self.study, self.base_values).columns

    @cached_property
    def tangents(self) -> Array:
        """Sensitivities to what is refitted, shape (rows, outputs, parameters)."""
        study = self.study
        return sensitivities(study, ExtendedModel(), study.base, self.base_values, self.base_predicted)

    @cached_property
    def floors(self) -> list[NoiseFloor]:
        """Noise floor of each channel."""
        bench = self.study.bench
        driving = [
            np.column_stack([r[m.signal] for m in bench.part.columns] or [np.zeros(len(r))])
            for r in bench.recordings.values()
        ]
        return [
            noise_floor([bench.raw[name][:, i] for name in bench.recordings], driving, bench.period)
            for i in range(len(bench.outputs))
        ]

    @cached_property
    def is_driven_in_steps(self) -> bool:
        """Whether a converter wrote something that drives the part."""
        return any(step_of(values) > 0.0 for values in self.recorded.driving.values())

    @cached_property
    def passed(self) -> Array:
        """Noise of what drives the part, passed through the model, shape (outputs,)."""
        bench = self.study.bench
        floors = [
            float(np.median([from_differences(r[m.signal]) for r in bench.recordings.values()]))
            for m in bench.part.columns
        ]
        if not any(floors):
            return np.zeros(len(bench.outputs))
        changes = self.study.replayed_with_noise(self.base_values, floors, DRAWS)
        return np.asarray(np.sqrt(np.nanmean(changes[:, self.rows] ** 2, axis=(0, 1))))

    def judge(self, predicted: Array, *, thorough: bool = True) -> tuple[Adequacy, ...]:
        """
        Judge a prediction of all rows, shape (rows, outputs), channel by channel.

        Args:
            predicted: What a model predicts.
            thorough: All regressors; the linear ones and the laws of the slots alone if False.
        """
        key = (hash(predicted.tobytes()), thorough)
        if key not in self._judged:
            left = np.nan_to_num(self.study.measured - predicted)
            with threadpool_limits(limits=1):
                self._judged[key] = tuple(
                    self._channel(i, left[:, i], thorough=thorough)
                    for i in range(len(self.study.bench.outputs))
                )
        return self._judged[key]

    @cached_property
    def _judged(self) -> dict[tuple[int, bool], tuple[Adequacy, ...]]:
        """What was judged already: several questions are asked of one prediction."""
        return {}

    def _channel(self, i: int, left: Array, *, thorough: bool) -> Adequacy:
        bench = self.study.bench
        rounding = ROUNDING * float(np.nanstd(self.study.measured[self.rows, i]))
        if np.sqrt(np.mean(left[self.rows] ** 2)) <= rounding:
            left = np.zeros_like(left)
        own = left[self.rows]
        predictors = self._predictors(i, left, thorough=thorough) if np.any(own) else []
        found = Adequacy(
            signal=bench.outputs[i],
            rms=float(np.sqrt(np.mean(own**2))),
            floor=self.floors[i],
            passed=float(self.passed[i]),
            predictors=tuple(sorted(predictors, key=lambda p: -p.share.value)),
            colour=colour_of(own, bench.row_period),
            events=self._times(events(left, self.rows, self._window)),
            has_steps=self.floors[i].step > 0.0 or self.is_driven_in_steps,
        )
        if found.is_within_floor:
            return found
        found = replace(found, chance=self._chance(left))
        if found.ratio < MANY_FLOORS and not found.is_uneven:
            return found
        tried = (max(1, round(time / bench.row_period)) for time in AVERAGED)
        set_off = (self._times(strikes(left, self.rows, self._window, every)) for every in tried)
        return replace(found, strikes=next(filter(None, set_off), ()))

    def _chance(self, left: Array) -> float:
        """Probability that noise is as uneven as a residual (rows,), but for hum."""
        highest = HIGHEST / self.study.bench.row_period
        quiet = without_mains(left, self.recorded.times, self.folds.rows, highest=highest)
        return chance_of_unevenness(quiet, self.rows)

    def _predictors(self, i: int, left: Array, *, thorough: bool) -> list[Predictor]:
        folds = self.folds
        recorded = self.recorded
        found: list[Predictor] = []

        def judged(kind: Kind, of: str, held: HeldOut, law: SlotLaw | None = None) -> None:
            share = share_of(left, held.explained, folds.block)
            if kind is Kind.MODULATED and share.interval.low <= 0.0:
                share = NO_SHARE  # the strongest of many lines, but not beyond chance
            found.append(Predictor(kind, of, share, law, held.frequency))

        own = self.tangents[:, i, :]
        if recorded.signals:
            held = ridge(left, np.hstack([recorded.linear, own]), folds)
            judged(Kind.LINEAR, self._nearest_part(left), held)
        for law, columns in self.laws.items():
            judged(Kind.LAW, str(law), ridge(left, np.hstack([columns[:, i, :], own]), folds), law)
        if thorough and recorded.signals:
            judged(Kind.TREES, "", trees(left, recorded.nonlinear, folds))
            highest = HIGHEST / self.study.bench.row_period
            long = self.long_folds
            ones = np.ones(len(left))
            judged(Kind.MODULATED, "1", line(left, ones, recorded.times, long, highest=highest))
            quiet = without_mains(left, recorded.times, folds.rows, highest=highest)
            for name, values in list(recorded.signals.items())[:MOST_LINES]:
                rows = recorded.on_rows(values)
                judged(Kind.MODULATED, name, line(quiet, rows, recorded.times, long, highest=highest))
                judged(Kind.PERIODIC, name, line_over(left, rows, folds))
        return found

    def _nearest_part(self, left: Array) -> str:
        """The one signal, memory or mode that the residual follows most, in words."""
        rows = self.folds.rows
        e = left[rows] - left[rows].mean()
        best = ""
        most = 0.0
        for name, columns in self.recorded.linear_parts.items():
            a = columns[rows] - columns[rows].mean(axis=0)
            normal = a.T @ a
            target = a.T @ e
            taken = float(target @ np.linalg.lstsq(normal, target, rcond=1e-10)[0])
            if taken > most:
                most = taken
                best = name
        return best

    @property
    def _window(self) -> int:
        """Rows in which power is counted."""
        return max(FEWEST_ROWS, round(LONGEST_EVENT / self.study.bench.row_period))

    def _times(self, first_rows: Integers) -> tuple[float, ...]:
        """Times of windows that begin with these rows [s]."""
        return tuple(float(row * self.study.bench.row_period) for row in first_rows)


def worst(channels: Sequence[Adequacy], key: Callable[[Adequacy], float]) -> Adequacy:
    """The channel with the largest of something."""
    return max(channels, key=key)

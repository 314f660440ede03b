"""
A nonparametric law: what no listed effect explains, learned in one of the slots.

All laws that the slots can have are regressed on the residual together with what is fitted already, with a
penalty on their roughness. Those that predict the held-out blocks best become models of their own, and are
fitted by steps of Gauss-Newton over true replays.

Source: Eilers, Marx, Statistical Science 11 (1996) 89 (penalised splines).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from master.diagnosis.numerics.arrays import Array
from master.diagnosis.numerics.gains import SMALLEST_GAIN, Gain, powers
from master.diagnosis.numerics.least_squares import Fit, bounded
from master.diagnosis.numerics.regression import penalised
from master.diagnosis.replay.placed_effect import free_parameters
from master.diagnosis.search.extended_model import ExtendedModel
from master.diagnosis.search.injection import Injection
from master.diagnosis.search.study import Study

from .describe import describe, shows_memory
from .fit import Descent, Promise, penalty_matrix, sensitivities
from .shapes import Law, laws

PENALTIES = (1e-4, 1e-2, 1.0, 100.0)  # on the roughness, over the mean power of an answer
LOOSER = 1e-2  # factor on the penalty of a law that is let rougher
BETTER = 0.01  # mean gain that this must bring
N_FITTED = 3  # laws that are fitted by replays
NEAR = 0.2  # of the best gain: a law that is no nearer is not fitted


@dataclass(frozen=True)
class LearnedLaw:
    """A learned law in a slot: the fit, its gain over the model without it, how many laws were tried."""

    model: ExtendedModel
    gain: Gain
    promise: Promise
    n_tried: int
    memory_shown: bool = True

    @property
    def shape(self) -> str:
        """The law in words."""
        return describe(self.model.effects[-1], self.fit.values, memory_shown=self.memory_shown)

    @property
    def fit(self) -> Fit:
        """The fit of base and effects."""
        return self.gain.fit


class _PenaltyGain(NamedTuple):
    """Penalty on the roughness and the mean gain on the held-out blocks with it."""

    penalty: float
    gain: float


@dataclass(frozen=True)
class _Task:
    """What a law is added to: a model with its fit, and the fit that a gain is over."""

    study: Study
    model: ExtendedModel
    fit: Fit
    reference: Fit


def learn(
    study: Study,
    model: ExtendedModel,
    fitted: Fit,
    places: Sequence[str],
    reference: Fit | None = None,
) -> LearnedLaw | None:
    """
    Fit the learned law that explains most in addition to a model; None if none promises anything.

    Args:
        study: The part.
        model: Effects that are there already.
        fitted: Where the fit of the law starts.
        places: Slots (`fmu.slot`) that may hold it.
        reference: The fit that the gain is over; `fitted` if None.
    """
    groups = laws(study, places)
    if not groups:
        return None
    study.say(f"{len(groups)} nonparametric laws tried")
    task = _Task(study, model, fitted, reference or fitted)
    promising = _promising(task, groups)
    study.build([(*model.effects, p.law.placed) for p in promising])
    n_tried = sum(map(len, groups))
    learned = [_fitted(task, p, n_tried) for p in promising]
    return max(learned, key=lambda law: law.gain.mean, default=None)


def relearned(study: Study, law: LearnedLaw, fitted: Fit) -> Fit:
    """Fit a law once more, on the rows of another study."""
    return Descent(study, law.model, law.promise).fit(fitted)


def _fitted(task: _Task, promise: Promise, n_tried: int) -> LearnedLaw:
    """Fit one law, and let it be rougher for as long as that pays on the held-out blocks."""
    study = task.study
    model = _with_law(task, promise.law)
    best: LearnedLaw | None = None
    while True:
        fitted = Descent(study, model, promise).fit(task.fit if best is None else best.fit)
        shown = shows_memory(study.signals[promise.law.placed.place])
        own = LearnedLaw(model, study.gain(task.reference, fitted), promise, n_tried, shown)
        if best is not None and own.gain.mean < best.gain.mean + BETTER:
            return best
        best = own
        if promise.penalty < PENALTIES[0]:
            return best
        promise = replace(promise, penalty=LOOSER * promise.penalty)


def _promising(task: _Task, groups: Sequence[Sequence[Law]]) -> list[Promise]:
    """The laws that predict the held-out blocks best by one linear step, each with its best penalty."""
    study = task.study
    values = dict(task.model.fixed) | dict(task.fit.values)
    base = {p.name: values[p.name] for p in study.base}
    regression = _Regression(task)
    injections: dict[str, Injection] = {}
    best = []
    for group in groups:
        promises: list[Promise] = []
        for law in group:
            place = law.placed.place
            if place not in injections:
                injections[place] = Injection(study, place, base)
            injection = injections[place]
            if injection.is_linear:
                answers = injection.answer(law.functions(study, study.signals[place]))
                promises += [
                    Promise(law, penalty, gain, injection) for penalty, gain in regression.gains(law, answers)
                ]
        if promises:
            best.append(max(promises, key=lambda p: p.gain))
    best = sorted((p for p in best if p.gain > SMALLEST_GAIN), key=lambda p: -p.gain)
    return [p for p in best[:N_FITTED] if p.gain > (1.0 - NEAR) * best[0].gain or p is best[0]]


class _Regression:
    """The residual of a fit, regressed on a law's answers and the sensitivities of what is fitted."""

    def __init__(self, task: _Task) -> None:
        study = task.study
        self.study = study
        parameters = (*study.base, *task.model.parameters)
        values = dict(task.model.fixed) | dict(task.fit.values)
        self.left = bounded((study.measured - task.fit.predicted) / study.output_scale)
        self.before = study.powers(task.reference.predicted)
        self.own = sensitivities(study, task.model, parameters, values, task.fit.predicted)
        self.priors = np.array([p.prior_weight for p in parameters])
        starts = np.array([p.start - task.fit.values[p.name] for p in parameters])
        self.starts = starts / np.array([p.scale for p in parameters])

    def gains(self, law: Law, answers: Array) -> list[_PenaltyGain]:
        """Mean gain with each penalty, from answers to the law's functions (rows, outputs, coefficients)."""
        study = self.study
        rows = study.fit_rows
        matrix = np.concatenate([self.own, answers], axis=2)
        centre = np.concatenate([self.starts, np.zeros(len(law.names))])
        gains = []
        for penalty in PENALTIES:
            penalties = penalty_matrix(law, answers[rows], penalty, self.priors)
            step = penalised(matrix[rows], self.left[rows], penalties, centre)
            rest = (self.left - matrix @ step) * study.output_scale
            power = powers(rest, study.held_out, study.output_scale)
            gains.append(_PenaltyGain(penalty, float(np.mean(np.log(self.before / power)))))
        return gains


def _with_law(task: _Task, law: Law) -> ExtendedModel:
    """The model with a law whose coefficients are free and start at zero."""
    rms = task.study.signal_rms(law.placed.place)
    own = tuple(
        replace(p, start=0.0, low=-np.inf, high=np.inf)
        for p in free_parameters(law.placed, rms)
        if p.name in law.names
    )
    return task.model.with_effect(law.placed, law.fixed, own)

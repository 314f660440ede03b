"""
Fit of a nonparametric law: steps of Gauss-Newton over true replays, with a penalty on its roughness.

    minimise  sum ((predicted - measured)/scale)^2 + (theta - start)' P (theta - start)

The derivatives to the coefficients are answers of the linear model to the law's functions along the present
replay (`injection.py`), those to the other parameters are differences.

Source: Eilers, Marx, Statistical Science 11 (1996) 89 (penalised splines); Nocedal, Wright, Numerical
Optimization (2006), Sec. 10.3.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from master.diagnosis.numerics.arrays import Array
from master.diagnosis.numerics.least_squares import Fit, FreeParameter, bounded
from master.diagnosis.numerics.regression import penalised
from master.diagnosis.search.extended_model import ExtendedModel
from master.diagnosis.search.injection import Injection
from master.diagnosis.search.study import Study

from .shapes import Law

RIDGE = 1e-6  # of the mean power of an answer: keeps coefficients finite that nothing excites
STEPS = 8
HALVINGS = 3  # of a step that does not lower the cost
ENOUGH = 1e-3  # relative fall of the cost below which the descent ends
DIFFERENCE = 1e-4  # of a parameter's scale, for a derivative


@dataclass(frozen=True)
class Promise:
    """A law with the penalty of its best linear step; `gain` is the mean gain on the held-out blocks."""

    law: Law
    penalty: float
    gain: float
    injection: Injection


def sensitivities(
    study: Study,
    model: ExtendedModel,
    parameters: Sequence[FreeParameter],
    values: Mapping[str, float],
    predicted: Array,
) -> Array:
    """
    Scaled sensitivities of all rows to parameters, by differences of replays.

    Args:
        study: The part.
        model: The effects in it.
        parameters: What is moved, away from the upper bound.
        values: All values by `fmu.variable`.
        predicted: Prediction at these values, shape (rows, outputs).

    Returns:
        Shape (rows, outputs, parameters).
    """
    columns = []
    for p in parameters:
        share = DIFFERENCE if values[p.name] + DIFFERENCE * p.scale < p.high else -DIFFERENCE
        shifted = dict(values) | {p.name: values[p.name] + share * p.scale}
        moved = study.simulate(model.effects, shifted, everything=True)
        columns.append(bounded((moved - predicted) / study.output_scale) / share)
    return np.stack(columns, axis=-1) if columns else np.zeros((*predicted.shape, 0))


def penalty_matrix(law: Law, answers: Array, penalty: float, priors: Array) -> Array:
    """
    Penalties on all unknowns: priors of the parameters before the law, roughness of its coefficients.

    Args:
        law: The law.
        answers: Answers to its functions on the rows that are fitted on, shape (rows, outputs, coefficients).
        penalty: On the roughness, over the mean power of an answer.
        priors: Weights of the other parameters' priors, shape (parameters,).

    Returns:
        Shape (parameters + coefficients,) squared.
    """
    n_before = len(priors)
    n = answers.shape[2]
    strength = float(np.sum(answers**2)) / n
    smooth = law.smoothness
    matrix = np.zeros((n_before + n, n_before + n))
    matrix[:n_before, :n_before] = np.diag(priors**2)
    matrix[n_before:, n_before:] = strength * (penalty * smooth.T @ smooth + RIDGE * np.eye(n))
    return matrix


@dataclass(frozen=True)
class _State:
    """Unknowns of a descent, shape (unknowns,), and what the model predicts there, shape (rows, outputs)."""

    theta: Array
    predicted: Array


class Descent:
    """Gauss-Newton over true replays, the answers from the injection as derivatives."""

    def __init__(self, study: Study, model: ExtendedModel, promise: Promise) -> None:
        self.study = study
        self.model = model
        self.law = promise.law
        self.injection = promise.injection
        self.penalty = promise.penalty
        self.free = (*study.base, *model.parameters)
        self.others = self.free[: len(self.free) - len(self.law.names)]
        self.start = np.array([p.start for p in self.free])
        self.low = np.array([p.low for p in self.free])
        self.high = np.array([p.high for p in self.free])
        self.scale = np.array([1.0 if p.name in self.law.names else p.scale for p in self.free])

    def fit(self, before: Fit) -> Fit:
        """Fit from a model with these values; a coefficient that it does not have starts at zero."""
        study = self.study
        here = _State(np.array([before.values.get(p.name, 0.0) for p in self.free]), before.predicted)
        matrix = self._derivatives(here)
        penalties = self._penalties(matrix)
        for i in range(STEPS):
            if i:
                matrix = self._derivatives(here)
            left = bounded((study.measured - here.predicted) / study.output_scale)[study.fit_rows]
            centre = (self.start - here.theta) / self.scale
            step = penalised(matrix[study.fit_rows], left, penalties, centre)
            cost = self._cost(here, penalties)
            lower = self._lower(here, step, penalties, cost)
            if lower is None:
                break
            here = lower
            if cost - self._cost(here, penalties) < ENOUGH * cost:
                break
        return self._result(here, matrix, penalties)

    def _lower(self, here: _State, step: Array, penalties: Array, cost: float) -> _State | None:
        """Go along a step, or a part of it, to a lower cost; None if there is none."""
        for halving in range(HALVINGS):
            theta = np.clip(here.theta + 0.5**halving * step * self.scale, self.low, self.high)
            trial = _State(theta, self._predicted(theta))
            if self._cost(trial, penalties) < cost:
                return trial
        return None

    def _penalties(self, matrix: Array) -> Array:
        answers = matrix[self.study.fit_rows][:, :, len(self.others) :]
        priors = np.array([p.prior_weight for p in self.others])
        return penalty_matrix(self.law, answers, self.penalty, priors)

    def _predicted(self, theta: Array) -> Array:
        return self.study.simulate(self.model.effects, self._values(theta), everything=True)

    def _values(self, theta: Array) -> dict[str, float]:
        names = [p.name for p in self.free]
        return dict(self.model.fixed) | dict(zip(names, theta.tolist(), strict=True))

    def _cost(self, state: _State, penalties: Array) -> float:
        study = self.study
        left = bounded((study.measured - state.predicted) / study.output_scale)[study.fit_rows]
        away = (state.theta - self.start) / self.scale
        return float(np.sum(left**2) + away @ penalties @ away)

    def _derivatives(self, here: _State) -> Array:
        """Scaled derivatives of all rows, shape (rows, outputs, unknowns)."""
        values = self._values(here.theta)
        own = sensitivities(self.study, self.model, self.others, values, here.predicted)
        answers = self.injection.answer(self.law.functions(self.study, self._signals(values)))
        return np.concatenate([own, answers], axis=2)

    def _signals(self, values: Mapping[str, float]) -> Mapping[str, Array]:
        """Signals of the law's slot; those of a mechanical one change with the law."""
        place = self.law.placed.place
        if "velocity" not in self.study.signals[place]:
            return self.study.signals[place]
        return self.study.slot_signals_with(self.model, values, place)

    def _result(self, state: _State, matrix: Array, penalties: Array) -> Fit:
        cost = self._cost(state, penalties)
        a = matrix[self.study.fit_rows].reshape(-1, len(state.theta))
        variance = cost / max(1, len(a) - len(state.theta))
        covariance = np.linalg.pinv(a.T @ a + penalties) * variance
        deviations = np.sqrt(np.maximum(np.diag(covariance), 0.0)) * self.scale
        names = [p.name for p in self.free]
        return Fit(
            name=self.model.name,
            values=dict(zip(names, state.theta.tolist(), strict=True)),
            deviations=dict(zip(names, deviations.tolist(), strict=True)),
            predicted=state.predicted,
            cost=0.5 * cost,
        )

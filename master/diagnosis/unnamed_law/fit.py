"""
Fit of a law without a name: steps of Gauss-Newton over true replays, with a penalty on its roughness.

    minimise  sum ((predicted - measured)/size)^2 + (theta - start)' P (theta - start)

The derivatives to the coefficients are answers of the linear model to the law's functions along the present
replay (`injection.py`), those to the other parameters are differences.

Source: Eilers, Marx, Statistical Science 11 (1996) 89 (penalised splines); Nocedal, Wright, Numerical
Optimization (2006), Sec. 10.3.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from master.diagnosis.numerics.arrays import Array
from master.diagnosis.numerics.least_squares import Fit, Parameter, bounded
from master.diagnosis.replay.slot_signals import slot_signals
from master.diagnosis.search.injection import Injection
from master.diagnosis.search.study import Extended, Study, merged

from .shapes import Law

RIDGE = 1e-6
STEPS, HALVINGS, ENOUGH = 8, 3, 1e-3
DIFFERENCE = 1e-4


@dataclass(frozen=True)
class Promise:
    """A law with the coefficients of one linear step; `gain` is the mean gain on the held-out blocks."""

    law: Law
    penalty: float
    gain: float
    injection: Injection


def sensitivities(study: Study, chosen: Extended, found: Fit) -> Array:
    """Scaled sensitivities of all rows to base and effects, shape (rows, outputs, parameters)."""
    values = dict(chosen.fixed) | dict(found.values)
    columns = []
    for p in (*study.base, *chosen.parameters):
        share = inward(p, values[p.name])
        moved = study.simulate(
            chosen.added, values | {p.name: values[p.name] + share * p.scale}, everything=True
        )
        columns.append(bounded((moved - found.predicted) / study.size) / share)
    shape = (*found.predicted.shape, 0)
    return np.stack(columns, axis=-1) if columns else np.zeros(shape)


def inward(p: Parameter, value: float) -> float:
    """Step for a difference over the parameter's scale, away from its upper bound."""
    return DIFFERENCE if value + DIFFERENCE * p.scale < p.high else -DIFFERENCE


def prior_of(study: Study, chosen: Extended) -> Array:
    """Weights of the priors of base and effects, per scaled parameter."""
    return np.array([p.scale / p.spread if p.spread else 0.0 for p in (*study.base, *chosen.parameters)])


def roughness(law: Law, n_before: int, columns: Array, penalty: float, prior: Array) -> Array:
    """Square roots of the penalties on all unknowns, priors first, shape (unknowns, unknowns)."""
    strength = float(np.sum(columns**2)) / columns.shape[2]
    smooth, n = law.smoothness, columns.shape[2]
    own = strength * (penalty * smooth.T @ smooth + RIDGE * np.eye(n))
    found = np.zeros((n_before + n, n_before + n))
    found[:n_before, :n_before] = np.diag(prior**2)
    found[n_before:, n_before:] = own
    return found


def solved(matrix: Array, left: Array, below: Array, target: Array) -> Array:
    """Solution x of least squares with the quadratic penalty (x - target)' below (x - target)."""
    a = matrix.reshape(-1, matrix.shape[2])
    return np.asarray(np.linalg.lstsq(a.T @ a + below, a.T @ left.ravel() + below @ target, rcond=1e-13)[0])


class Descent:
    """Gauss-Newton over true replays, the answers from the injection as derivatives."""

    def __init__(self, study: Study, extended: Extended, best: Promise) -> None:
        self.study, self.extended, self.best = study, extended, best
        self.free = (*study.base, *extended.parameters)
        self.own = self.free[: len(self.free) - len(best.law.names)]
        self.start = np.array([p.start for p in self.free])
        self.low = np.array([p.low for p in self.free])
        self.high = np.array([p.high for p in self.free])
        self.scale = np.array([1.0 if p.name in best.law.names else p.scale for p in self.free])
        self.below = np.zeros((0, 0))

    def fit(self, found: Fit) -> Fit:
        """Fit from the model without the law, whose coefficients are zero."""
        study = self.study
        theta = np.array([found.values.get(p.name, 0.0) for p in self.free])
        predicted = found.predicted
        for _ in range(STEPS):
            matrix = self._derivatives(theta, predicted)
            if not len(self.below):
                law, n = self.best.law, len(self.own)
                prior = np.array([p.scale / p.spread if p.spread else 0.0 for p in self.own])
                columns = matrix[study.fit_rows][:, :, n:]
                self.below = roughness(law, n, columns, self.best.penalty, prior)
            left = bounded((study.measured - predicted) / study.size)[study.fit_rows]
            step = solved(matrix[study.fit_rows], left, self.below, (self.start - theta) / self.scale)
            cost = self._cost(theta, predicted)
            for halving in range(HALVINGS):
                moved = np.clip(theta + 0.5**halving * step * self.scale, self.low, self.high)
                trial = self._predicted(moved)
                if self._cost(moved, trial) < cost:
                    break
            else:
                break
            gained = cost - self._cost(moved, trial)
            theta, predicted = moved, trial
            if gained < ENOUGH * cost:
                break
        return self._result(theta, predicted, matrix)

    def _predicted(self, theta: Array) -> Array:
        return self.study.simulate(self.extended.added, self._values(theta), everything=True)

    def _values(self, theta: Array) -> dict[str, float]:
        names = [p.name for p in self.free]
        return dict(self.extended.fixed) | dict(zip(names, theta.tolist(), strict=True))

    def _cost(self, theta: Array, predicted: Array) -> float:
        left = bounded((self.study.measured - predicted) / self.study.size)[self.study.fit_rows]
        away = (theta - self.start) / self.scale
        return float(np.sum(left**2) + away @ self.below @ away)

    def _derivatives(self, theta: Array, predicted: Array) -> Array:
        """Scaled derivatives of all rows, shape (rows, outputs, unknowns)."""
        study, values = self.study, self._values(theta)
        columns = []
        for p in self.own:
            share = inward(p, values[p.name])
            moved = study.simulate(
                self.extended.added, values | {p.name: values[p.name] + share * p.scale}, everything=True
            )
            columns.append(bounded((moved - predicted) / study.size) / share)
        law = self.best.law
        answers = self.best.injection.answer(law.functions(study, self._signals(values)))
        return np.concatenate([np.stack(columns, axis=-1), answers], axis=2) if columns else answers

    def _signals(self, values: Mapping[str, float]) -> Mapping[str, Array]:
        """Signals of the law's slot; those of a mechanical one change with the law."""
        study, added = self.study, self.best.law.added
        slot = f"{added.fmu}.{added.slot}"
        if "velocity" not in study.signals[slot]:
            return study.signals[slot]
        player = study.pool.player(self.extended.added)
        whole = merged(study.system.values, values)
        return slot_signals(study.system, study.bench, player, whole, (added.fmu,))[slot]

    def _result(self, theta: Array, predicted: Array, matrix: Array) -> Fit:
        study = self.study
        a = matrix[study.fit_rows].reshape(-1, len(theta))
        variance = self._cost(theta, predicted) / max(1, len(a) - len(theta))
        covariance = np.linalg.pinv(a.T @ a + self.below) * variance
        deviations = np.sqrt(np.maximum(np.diag(covariance), 0.0)) * self.scale
        names = [p.name for p in self.free]
        return Fit(
            self.extended.name,
            dict(zip(names, theta.tolist(), strict=True)),
            dict(zip(names, deviations.tolist(), strict=True)),
            predicted,
            0.5 * self._cost(theta, predicted),
            0,
            (),
        )

"""
Bounded least squares on the output error, from several starts, with the uncertainty of what it finds.

    minimise  sum over rows in use of ((predicted - measured) / size)^2 + sum of ((theta - prior) / spread)^2

Sensitivities that the caller knows already serve for the first few steps: where a model is nearly linear in a
parameter, finding them anew in every step costs replays and gains nothing.

Source: Ljung, System Identification (1999), Secs. 7.2 (output error), 9.2 (covariance).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

from master.diagnosis.numerics.arrays import Array

Mask = NDArray[np.bool_]
Simulate = Callable[[Array], Array]
FAR = 1e4
STEP = 1e-5
KEPT = 4


@dataclass(frozen=True)
class Parameter:
    """A number to fit; `scale` is its typical size, `spread` the deviation of a prior around `start`."""

    name: str
    start: float
    low: float = -np.inf
    high: float = np.inf
    scale: float = 1.0
    spread: float | None = None


@dataclass(frozen=True)
class Candidate:
    """
    A model to try.

    `simulate(theta)` gives what the model predicts at every row, shape (n, outputs), NaN where it diverged.
    `starts` are values by name for more first guesses. `known` are sensitivities of the predictions
    (rows in use times outputs, scaled like the residual) by parameter, kept for the first steps.
    """

    name: str
    parameters: tuple[Parameter, ...]
    simulate: Simulate
    starts: tuple[Mapping[str, float], ...] = field(default=({},))
    known: Mapping[str, Array] = field(default_factory=dict)


@dataclass(frozen=True)
class Fit:
    """Parameters by name, their standard deviations, the prediction of all rows (n, outputs), the cost."""

    name: str
    values: Mapping[str, float]
    deviations: Mapping[str, float]
    predicted: Array
    cost: float
    n_simulations: int
    at_bound: tuple[str, ...]


def fit(
    candidate: Candidate,
    measured: Array,
    in_use: Mask,
    *,
    size: Array | None = None,
    evaluations: int = 30,
    tolerance: float = 1e-9,
) -> Fit:
    """
    Fit a candidate to a measurement.

    Args:
        candidate: Model with its parameters.
        measured: Shape (n, outputs).
        in_use: Rows to fit on, shape (n,), Boolean.
        size: Scale of each output, shape (outputs,); rms of the measurement if None.
        evaluations: Largest number of residual evaluations from each start, without those for the gradient.
        tolerance: Relative change of the cost at which the search stops.
    """
    rows: Mask = np.asarray(in_use, dtype=bool)
    problem = _Problem(candidate, measured, rows, _size(measured, rows) if size is None else size)
    if not candidate.parameters:
        return problem.result(
            np.zeros(0), np.zeros((0, 0)), 0.5 * float(np.sum(problem.residual(np.zeros(0)) ** 2))
        )
    best = None
    for start in candidate.starts:
        guess = problem.first_guess(start)
        if not np.isfinite(guess).all():  # estimated along a replay that diverged
            guess = problem.first_guess({})
        found = least_squares(
            problem.residual,
            guess,
            problem.jacobian,
            bounds=problem.bounds,
            x_scale="jac",
            xtol=1e-7,
            ftol=tolerance,
            max_nfev=evaluations,
        )
        if best is None or found.cost < best.cost:
            best = found
    assert best is not None
    return problem.result(best.x, np.asarray(best.jac), float(best.cost))


def bounded(residual: Array) -> Array:
    """Replace what a diverged simulation leaves by a large number."""
    return np.clip(np.nan_to_num(residual, nan=FAR, posinf=FAR, neginf=-FAR), -FAR, FAR)


class _Problem:
    """Scaled residual of a candidate."""

    def __init__(self, candidate: Candidate, measured: Array, rows: Mask, size: Array) -> None:
        self.candidate, self.measured, self.rows, self.size = candidate, measured, rows, size
        ps = candidate.parameters
        self.scale = np.array([p.scale for p in ps])
        self.start = np.array([p.start for p in ps])
        self.spread = np.array([np.inf if p.spread is None else p.spread for p in ps])
        self.bounds = (
            np.array([p.low for p in ps]) / self.scale,
            np.array([p.high for p in ps]) / self.scale,
        )
        self.n_simulations = self.n_jacobians = 0
        self.last: tuple[Array, Array] = (np.zeros(0), np.zeros(0))

    def first_guess(self, start: Mapping[str, float]) -> Array:
        values = np.array([start.get(p.name, p.start) for p in self.candidate.parameters]) / self.scale
        low, high = self.bounds
        margin = 1e-6 * np.maximum(1.0, np.where(np.isfinite(high - low), high - low, 1.0))
        return np.asarray(np.clip(values, low + margin, high - margin))

    def residual(self, scaled: Array) -> Array:
        self.n_simulations += 1
        theta = scaled * self.scale
        left = ((self.candidate.simulate(theta) - self.measured) / self.size)[self.rows].ravel()
        prior = (theta - self.start) / self.spread
        found = np.concatenate([bounded(left), prior[np.isfinite(self.spread)]])
        self.last = (scaled.copy(), found)
        return found

    def jacobian(self, scaled: Array) -> Array:
        """Forward differences away from the nearer bound, but for what is known in the first steps."""
        here = self.last[1] if np.array_equal(self.last[0], scaled) else self.residual(scaled)
        known = self.candidate.known if self.n_jacobians < KEPT else {}
        self.n_jacobians += 1
        columns = [
            self._known(known[p.name], i) if p.name in known else self._difference(scaled, here, i)
            for i, p in enumerate(self.candidate.parameters)
        ]
        return np.column_stack(columns)

    def _known(self, sensitivity: Array, i: int) -> Array:
        prior = np.where(np.arange(len(self.spread)) == i, self.scale / self.spread, 0.0)
        return np.concatenate([sensitivity, prior[np.isfinite(self.spread)]])

    def _difference(self, scaled: Array, here: Array, i: int) -> Array:
        step = STEP * max(abs(scaled[i]), 1e-3)
        moved = scaled.copy()
        moved[i] += step if moved[i] + step < self.bounds[1][i] else -step
        return np.asarray((self.residual(moved) - here) / (moved[i] - scaled[i]))

    def result(self, scaled: Array, jacobian: Array, cost: float) -> Fit:
        theta, names = scaled * self.scale, [p.name for p in self.candidate.parameters]
        n = int(self.rows.sum()) * self.measured.shape[1]
        variance = 2.0 * cost / max(1, n - len(theta))
        covariance = np.linalg.pinv(jacobian.T @ jacobian) * variance
        deviations = np.sqrt(np.maximum(np.diag(covariance), 0.0)) * self.scale
        low, high = self.bounds
        bound = [
            n for n, v, a, b in zip(names, scaled, low, high, strict=True) if v - a < 1e-5 or b - v < 1e-5
        ]
        return Fit(
            self.candidate.name,
            dict(zip(names, theta.tolist(), strict=True)),
            dict(zip(names, deviations.tolist(), strict=True)),
            self.candidate.simulate(theta),
            cost,
            self.n_simulations,
            tuple(bound),
        )


def _size(measured: Array, rows: Mask) -> Array:
    size = measured[rows].std(axis=0)
    return np.where(size > 0.0, size, 1.0)

"""
Bounded least squares on the output error, from several starts, with the uncertainty of what it finds.

    minimise  sum over rows in use of ((predicted - measured) / scale)^2 + sum of ((theta - prior) / spread)^2

Sensitivities that the caller already knows are used for the first few steps: where a model is nearly linear
in a parameter, finding them again in every step costs replays and gains nothing.

Source: Ljung, System Identification (1999), Sec. 7.2 (output error).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

import numpy as np
import scipy  # loads its packages when they are used

from .arrays import Array, Mask
from .deviations import sandwich

Simulate = Callable[[Array], Array]

FAR = 1e4  # over the scale: what a diverged simulation counts as
STEP = 1e-5  # of a parameter's scale, for the difference that gives a derivative
LEAST_OF_STEP = 1e-3  # of the scale: a parameter near zero is moved by STEP of this
KEPT = 4  # first steps that use the sensitivities that the caller knows
INSIDE = 1e-6  # of the distance of the bounds: how far inside a first guess is
AT_BOUND = 1e-5  # of the scale: nearer to a bound is at it
PARAMETER_TOLERANCE = 1e-7  # relative change of the parameters at which the search stops


@dataclass(frozen=True)
class FreeParameter:
    """A number to fit; `scale` is its typical size, `spread` the deviation of a prior around `start`."""

    name: str
    start: float
    low: float = -np.inf
    high: float = np.inf
    scale: float = 1.0
    spread: float | None = None

    @property
    def prior_weight(self) -> float:
        """Weight of the prior for the parameter over its scale, 0 without one."""
        return self.scale / self.spread if self.spread else 0.0

    def prior_distance(self, value: float) -> float:
        """How far `start` is above a value, in deviations of the prior, 0 without one."""
        return (self.start - value) / self.spread if self.spread else 0.0


@dataclass(frozen=True)
class Candidate:
    """
    A model to try.

    `simulate(theta)` returns what the model predicts at every row, shape (n, outputs), NaN where it diverged.
    `starts` are values by name for more first guesses. `known` are sensitivities of the predictions
    (rows in use times outputs, scaled like the residual) by parameter, kept for the first steps.
    """

    name: str
    parameters: tuple[FreeParameter, ...]
    simulate: Simulate
    starts: tuple[Mapping[str, float], ...] = field(default=({},))
    known: Mapping[str, Array] = field(default_factory=dict)


@dataclass(frozen=True)
class Fit:
    """
    Parameters by name, their standard deviations, the prediction of all rows (n, outputs), the cost.

    `covariance` is that of the parameters in the order of `values`, None where only deviations are known.
    """

    name: str
    values: Mapping[str, float]
    deviations: Mapping[str, float]
    predicted: Array
    cost: float
    n_simulations: int = 0
    at_bound: tuple[str, ...] = ()
    covariance: Array | None = None


def fit(
    candidate: Candidate,
    measured: Array,
    in_use: Mask,
    *,
    output_scale: Array | None = None,
    evaluations: int = 30,
    tolerance: float = 1e-9,
    is_sketch: bool = False,
) -> Fit:
    """
    Fit a candidate to a measurement.

    Args:
        candidate: Model with its parameters.
        measured: Shape (n, outputs).
        in_use: Rows to fit on, shape (n,).
        output_scale: Scale of each output, shape (outputs,); deviation of the measurement if None.
        evaluations: Largest number of residual evaluations from each start, without those for the gradient.
        tolerance: Relative change of the cost at which the search stops.
        is_sketch: Whether values and cost are all that is asked for; deviations and prediction are empty.
    """
    rows: Mask = np.asarray(in_use, dtype=bool)
    scale = _deviation(measured, rows) if output_scale is None else output_scale
    problem = _Problem(candidate, measured, rows, scale)
    if not candidate.parameters:
        cost = 0.5 * float(np.sum(problem.residual(np.zeros(0)) ** 2))
        return problem.result(np.zeros(0), np.zeros((0, 0)), cost)
    best = None
    for start in candidate.starts:
        guess = problem.first_guess(start)
        if not np.isfinite(guess).all():  # estimated along a replay that diverged
            guess = problem.first_guess({})
        solution = scipy.optimize.least_squares(
            problem.residual,
            guess,
            problem.jacobian,
            bounds=problem.bounds,
            x_scale="jac",
            xtol=PARAMETER_TOLERANCE,
            ftol=tolerance,
            max_nfev=evaluations,
        )
        if best is None or solution.cost < best.cost:
            best = solution
    assert best is not None
    if is_sketch:
        names = [p.name for p in candidate.parameters]
        values = dict(zip(names, (best.x * problem.scale).tolist(), strict=True))
        return Fit(candidate.name, values, {}, measured[:0], float(best.cost), problem.n_simulations)
    return problem.result(best.x, np.asarray(best.jac), float(best.cost))


def bounded(residual: Array) -> Array:
    """Replace what a diverged simulation leaves by a large number, shape of the residual."""
    return np.clip(np.nan_to_num(residual, nan=FAR, posinf=FAR, neginf=-FAR), -FAR, FAR)


class _Problem:
    """Scaled residual of a candidate; an unknown is a parameter over its scale."""

    def __init__(self, candidate: Candidate, measured: Array, rows: Mask, output_scale: Array) -> None:
        self.candidate = candidate
        self.measured = measured
        self.rows = rows
        self.output_scale = output_scale
        parameters = candidate.parameters
        self.scale = np.array([p.scale for p in parameters])
        self.start = np.array([p.start for p in parameters])
        self.spread = np.array([np.inf if p.spread is None else p.spread for p in parameters])
        self.bounds = (
            np.array([p.low for p in parameters]) / self.scale,
            np.array([p.high for p in parameters]) / self.scale,
        )
        self.n_simulations = 0
        self.n_jacobians = 0
        self.last_unknowns: Array = np.zeros(0)
        self.last_residual: Array = np.zeros(0)

    def first_guess(self, start: Mapping[str, float]) -> Array:
        values = np.array([start.get(p.name, p.start) for p in self.candidate.parameters]) / self.scale
        low, high = self.bounds
        margin = INSIDE * np.maximum(1.0, np.where(np.isfinite(high - low), high - low, 1.0))
        return np.asarray(np.clip(values, low + margin, high - margin))

    def residual(self, unknowns: Array) -> Array:
        self.n_simulations += 1
        theta = unknowns * self.scale
        left = ((self.candidate.simulate(theta) - self.measured) / self.output_scale)[self.rows].ravel()
        prior = (theta - self.start) / self.spread
        residual = np.concatenate([bounded(left), prior[np.isfinite(self.spread)]])
        self.last_unknowns = unknowns.copy()
        self.last_residual = residual
        return residual

    def jacobian(self, unknowns: Array) -> Array:
        """Forward differences away from the nearer bound, but for what is known in the first steps."""
        is_last = np.array_equal(self.last_unknowns, unknowns)
        here = self.last_residual if is_last else self.residual(unknowns)
        known = self.candidate.known if self.n_jacobians < KEPT else {}
        self.n_jacobians += 1
        columns = [
            self._known(known[p.name], i) if p.name in known else self._difference(unknowns, here, i)
            for i, p in enumerate(self.candidate.parameters)
        ]
        return np.column_stack(columns)

    def _known(self, sensitivity: Array, i: int) -> Array:
        prior = np.where(np.arange(len(self.spread)) == i, self.candidate.parameters[i].prior_weight, 0.0)
        return np.concatenate([sensitivity, prior[np.isfinite(self.spread)]])

    def _difference(self, unknowns: Array, here: Array, i: int) -> Array:
        step = STEP * max(abs(unknowns[i]), LEAST_OF_STEP)
        moved = unknowns.copy()
        moved[i] += step if moved[i] + step < self.bounds[1][i] else -step
        return np.asarray((self.residual(moved) - here) / (moved[i] - unknowns[i]))

    def result(self, unknowns: Array, jacobian: Array, cost: float) -> Fit:
        theta = unknowns * self.scale
        names = [p.name for p in self.candidate.parameters]
        covariance = np.zeros((0, 0))
        if len(theta):
            n_priors = int(np.isfinite(self.spread).sum())
            covariance = sandwich(jacobian, self.residual(unknowns), self.measured.shape[1], n_priors)
        deviations = np.sqrt(np.maximum(np.diag(covariance), 0.0)) * self.scale
        limits = zip(names, unknowns, *self.bounds, strict=True)
        at_bound = [name for name, v, low, high in limits if v - low < AT_BOUND or high - v < AT_BOUND]
        return Fit(
            name=self.candidate.name,
            values=dict(zip(names, theta.tolist(), strict=True)),
            deviations=dict(zip(names, deviations.tolist(), strict=True)),
            predicted=self.candidate.simulate(theta),
            cost=cost,
            n_simulations=self.n_simulations,
            at_bound=tuple(at_bound),
            covariance=covariance * np.outer(self.scale, self.scale),
        )


def _deviation(measured: Array, rows: Mask) -> Array:
    """Standard deviation of each output, 1 for one that does not move."""
    deviation = measured[rows].std(axis=0)
    return np.where(deviation > 0.0, deviation, 1.0)

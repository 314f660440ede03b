"""Start values that were not measured: those with which a replay meets what was."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from scipy.optimize import least_squares, minimize_scalar

from master.diagnosis.case.cut import Values
from master.diagnosis.numerics.arrays import Array
from master.text.signal_name import SignalName

HEAD = 0.15  # share of a recording on which values of its own are estimated
N_GRID = 15  # start values tried between the bounds, before the best is refined
GRID_TOLERANCE = 1e-5  # of the distance of the bounds
N_STEPS = 2  # for several start values: the outputs are nearly linear in them, so with the same derivatives
DIFFERENCE = 1e-3  # of the distance of the bounds, for a derivative
NEARLY = 1e-4  # of the first step: a second one that is no longer shows that the derivatives hold
N_TRIALS = 10  # for parameters, in which the outputs are not linear
DIVERGED = 1e6  # deviations: what a row is off whose outputs are not finite

Bounds = Mapping[str, tuple[float, float]]


def head(n: int) -> int:
    """Number of rows of the first part of n rows, on which values of their own are estimated."""
    return max(2, round(HEAD * n))


@dataclass(frozen=True)
class StartEstimate:
    """
    Replays of one segment with other start values, against what was measured.

    `play(values, n)` returns the outputs of the first n rows, shape (n, outputs); `target` is what was
    measured, shape (rows, outputs).
    """

    play: Callable[[Values, int], Array]
    values: Values
    target: Array

    def residual(self, starts: Mapping[str, float], n: int) -> Array:
        """What the first n rows leave, each output over its deviation, shape (n * outputs,)."""
        n = min(n, len(self.target))
        left = self.play(self.with_starts(starts), n)[:n] - self.target[:n]
        spread = self.target.std(axis=0)
        return np.asarray((left / np.where(spread > 0.0, spread, 1.0)).ravel())

    def with_starts(self, starts: Mapping[str, float]) -> Values:
        """Return the values with start values by `fmu.variable`."""
        values = {name: dict(v) for name, v in self.values.items()}
        for key, value in starts.items():
            name, variable = SignalName(key).parts
            values[name][variable] = value
        return values


class Stepped(NamedTuple):
    """Values with the start values, and what turns a residual into a step; None where there is none."""

    values: Values
    inverse: Array | None


def by_grid(estimate: StartEstimate, name: str, bounds: tuple[float, float]) -> Values:
    """Estimate one start value on the first part of a recording."""
    low, high = bounds
    n = head(len(estimate.target))

    def cost(value: float) -> float:
        left = estimate.residual({name: float(value)}, n)
        return float(left @ left) if np.isfinite(left).all() else np.inf

    grid = np.linspace(low, high, N_GRID)
    best = int(np.argmin([cost(v) for v in grid]))
    around = (float(grid[max(0, best - 1)]), float(grid[min(N_GRID - 1, best + 1)]))
    refined = minimize_scalar(
        cost, bounds=around, method="bounded", options={"xatol": GRID_TOLERANCE * (high - low)}
    )
    return estimate.with_starts({name: float(refined.x)})


def by_fit(estimate: StartEstimate, bounds: Bounds) -> Values:
    """Estimate parameters within their bounds on the first part of a recording."""
    names = list(bounds)
    lows, highs = np.array([bounds[name] for name in names]).T
    n = head(len(estimate.target))

    def at(u: Array) -> Array:
        return np.asarray(lows + (u - 1.0) * (highs - lows))  # from 1 to 2: steps go with the distance

    def residual(u: Array) -> Array:
        left = estimate.residual(dict(zip(names, at(u).tolist(), strict=True)), n)
        return np.where(np.isfinite(left), left, DIVERGED)

    middle = np.full(len(names), 1.5)
    step = np.full(len(names), DIFFERENCE)
    found = least_squares(residual, middle, bounds=(1.0, 2.0), diff_step=step, max_nfev=N_TRIALS)
    return estimate.with_starts(dict(zip(names, at(found.x).tolist(), strict=True)))


def by_steps(estimate: StartEstimate, bounds: Bounds, n: int, known: Array | None = None) -> Stepped:
    """
    Estimate start values on the first n rows of a segment by Newton steps from the middle of their bounds.

    `known` is the `inverse` found at other parameters; it serves where a second step with it is next to none.
    """
    names = list(bounds)
    middle = np.array([0.5 * (low + high) for low, high in bounds.values()])
    spans = np.array([high - low for low, high in bounds.values()])

    def residual(x: Array) -> Array:
        return estimate.residual(dict(zip(names, x, strict=True)), n)

    def result(x: Array, inverse: Array | None) -> Stepped:
        return Stepped(estimate.with_starts(dict(zip(names, x.tolist(), strict=True))), inverse)

    here = residual(middle)
    if known is not None:
        places = _newton(residual, middle, here, known)
        sizes = [float(np.linalg.norm(step / spans)) for step in np.diff(places, axis=0)]
        if len(sizes) == N_STEPS and sizes[-1] <= NEARLY * sizes[0]:
            return result(places[-1], known)
    columns = []
    for i, step in enumerate(DIFFERENCE * spans):
        moved = middle.copy()
        moved[i] += step
        columns.append((residual(moved) - here) / step)
    matrix = np.column_stack(columns)
    if not np.isfinite(matrix).all():
        return result(middle, None)
    inverse = np.linalg.pinv(matrix)
    return result(_newton(residual, middle, here, inverse)[-1], inverse)


def _newton(residual: Callable[[Array], Array], x: Array, left: Array, inverse: Array) -> list[Array]:
    """Where steps lead from x, which leaves `left`; fewer steps where a replay diverges."""
    places = [x]
    for _ in range(N_STEPS):
        if len(places) > 1:
            left = residual(places[-1])
        if not np.isfinite(left).all():
            break
        places.append(places[-1] - inverse @ left)
    return places

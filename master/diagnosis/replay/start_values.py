"""Start values that were not measured: those with which a replay meets what was."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np
from scipy.optimize import minimize_scalar

from master.diagnosis.case.cut import Values
from master.diagnosis.numerics.arrays import Array
from master.text.signal_name import SignalName

HEAD = 0.15  # share of a recording on which one start value is estimated
N_GRID = 15  # start values tried between the bounds, before the best is refined
GRID_TOLERANCE = 1e-5  # of the distance of the bounds
N_STEPS = 2  # Gauss-Newton steps for several start values: the outputs are nearly linear in them
DIFFERENCE = 1e-3  # of the distance of the bounds, for a derivative

Bounds = Mapping[str, tuple[float, float]]


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


def by_grid(estimate: StartEstimate, name: str, bounds: tuple[float, float]) -> Values:
    """Estimate one start value on the first part of a recording."""
    low, high = bounds
    n = max(2, round(HEAD * len(estimate.target)))

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


def by_steps(estimate: StartEstimate, bounds: Bounds, rows: int | None = None) -> Values:
    """
    Estimate values by Gauss-Newton steps from the middle of their bounds.

    Args:
        estimate: Replays of a segment.
        bounds: By `fmu.variable`.
        rows: First rows of the segment that are looked at; None: all.
    """
    names = list(bounds)
    x = np.array([0.5 * (low + high) for low, high in bounds.values()])
    steps = np.array([DIFFERENCE * (high - low) for low, high in bounds.values()])
    n = len(estimate.target) if rows is None else max(2, rows)
    for _ in range(N_STEPS):
        here = estimate.residual(dict(zip(names, x, strict=True)), n)
        columns = []
        for i, step in enumerate(steps):
            moved = x.copy()
            moved[i] += step
            columns.append((estimate.residual(dict(zip(names, moved, strict=True)), n) - here) / step)
        matrix = np.column_stack(columns)
        if not (np.isfinite(matrix).all() and np.isfinite(here).all()):
            break
        x = x - np.linalg.lstsq(matrix, here, rcond=None)[0]
    return estimate.with_starts(dict(zip(names, x.tolist(), strict=True)))

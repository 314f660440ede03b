"""What a number depends on: Sobol indices of a Saltelli design, and tornado bars of any sample."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .interval import Interval

Floats = NDArray[np.float64]

_RESAMPLES = 400
_PARTS = 5
_FEWEST = 50


@dataclass(frozen=True)
class SobolIndex:
    """Shares of the variance that go with one input: alone (`first`), and with all its interactions."""

    key: str
    first: Interval
    total: Interval


def sobol_indices(keys: Sequence[str], values: Floats, seed: int = 1) -> list[SobolIndex]:
    """
    Estimate the indices of a number from the blocks A, B, A with column i of B.

    Args:
        keys: The inputs, in the order of the design.
        values: The number in all runs of the design, shape (n (keys + 2),); NaN where a run has none: points
            of which a run has none are left out.
        seed: For the intervals of 95 %, by bootstrap.

    Source: Saltelli et al., Variance based sensitivity analysis of model output, Computer Physics
    Communications 181 (2010), 259-270, table 2, (b) and (f).
    """
    blocks = values.reshape(len(keys) + 2, -1)
    blocks = blocks[:, np.isfinite(blocks).all(axis=0)]
    n = blocks.shape[1]
    if n < 2 or np.ptp(blocks[:2]) == 0.0:
        nothing = Interval(float("nan"), float("nan"), float("nan"), n)
        return [SobolIndex(key, nothing, nothing) for key in keys]
    blocks = blocks - np.mean(blocks[:2])
    rng = np.random.default_rng(seed)
    estimates = _indices(blocks)
    resampled = np.array([_indices(blocks[:, rng.integers(0, n, n)]) for _ in range(_RESAMPLES)])
    low, high = np.quantile(resampled, [0.025, 0.975], axis=0)

    def interval(which: int, i: int) -> Interval:
        return Interval(float(estimates[which, i]), float(low[which, i]), float(high[which, i]), n)

    return [SobolIndex(key, interval(0, i), interval(1, i)) for i, key in enumerate(keys)]


def _indices(blocks: Floats) -> Floats:
    """First and total indices, shape (2, inputs)."""
    a = blocks[0]
    b = blocks[1]
    mixed = blocks[2:]
    variance = np.var(blocks[:2])
    first = np.mean(b * (mixed - a), axis=1) / variance
    total = 0.5 * np.mean((a - mixed) ** 2, axis=1) / variance
    return np.array([first, total])


@dataclass(frozen=True)
class Bar:
    """Mean of a number over the lowest and the highest fifth of an input."""

    key: str
    low: float
    high: float

    @property
    def span(self) -> float:
        """How much the number changes with the input."""
        return abs(self.high - self.low)


def tornado(inputs: dict[str, Floats], values: Floats) -> list[Bar]:
    """
    Compare the means of a number over the lowest and the highest fifth of each input, largest change first.

    Args:
        inputs: Numbers by key, shape (runs,).
        values: The number, shape (runs,); NaN where a run has none.
    """
    has_value = np.isfinite(values)
    found: list[Bar] = []
    if has_value.sum() < 2 * _PARTS:
        return found
    for key, column in inputs.items():
        x = column[has_value]
        y = values[has_value]
        if np.ptp(x) == 0.0:
            continue
        low, high = np.quantile(x, [1.0 / _PARTS, 1.0 - 1.0 / _PARTS])
        found.append(Bar(key, float(np.mean(y[x <= low])), float(np.mean(y[x >= high]))))
    return sorted(found, key=lambda bar: -bar.span)

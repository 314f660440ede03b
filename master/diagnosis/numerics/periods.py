"""
Periods of a force that repeats along the way: the spectrum of a residual over the position.

No other start is near enough for a fit: all repetitions along the way have to be right to a fraction of one.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from master.diagnosis.numerics.arrays import Array

MOST_CYCLES, A_CYCLE = 60, 2  # along the way; trials for each


def likely_periods(position: Array, gain: Callable[[Array], float], n: int) -> list[float]:
    """
    Periods that a residual suggests, most likely first.

    Args:
        position: Shape (samples,).
        gain: Share of the residual's power that functions of time (samples, 2) explain when they are added.
        n: Number of suggestions.

    Returns:
        Periods from the length of the way to a sixtieth of it, in the unit of the position.
    """
    way = float(np.ptp(position))
    if way == 0.0:
        return []
    cycles = np.arange(A_CYCLE, A_CYCLE * MOST_CYCLES + 1) / A_CYCLE
    gains = np.array([gain(waves(position, way / c)) for c in cycles])
    around = np.concatenate([[-np.inf], gains, [-np.inf]])
    peaks = np.flatnonzero((gains >= around[:-2]) & (gains >= around[2:]))
    best = peaks[np.argsort(-gains[peaks], kind="stable")][:n]
    return [way / float(cycles[i]) for i in best]


def waves(position: Array, period: float) -> Array:
    """Sine and cosine along the way, shape (samples, 2)."""
    angle = 2.0 * np.pi * position / period
    return np.column_stack([np.sin(angle), np.cos(angle)])

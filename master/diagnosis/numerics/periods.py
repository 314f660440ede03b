"""
Periods of a force that repeats with the position: the spectrum of a residual over the position.

No other start is near enough for a fit: all repetitions over the displacement have to be right to a fraction
of one.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from .arrays import Array

MOST_CYCLES = 60  # over the whole displacement
TRIALS_PER_CYCLE = 2


def likely_periods(position: Array, gain: Callable[[Array], float], n: int) -> list[float]:
    """
    Periods that a residual suggests, most likely first.

    Args:
        position: Shape (samples,).
        gain: Share of the residual's power that functions of time (samples, 2) explain when they are added.
        n: Number of suggestions.

    Returns:
        Periods from the whole displacement to a sixtieth of it, in the unit of the position.
    """
    displacement = float(np.ptp(position))
    if displacement == 0.0:
        return []
    cycles = np.arange(TRIALS_PER_CYCLE, TRIALS_PER_CYCLE * MOST_CYCLES + 1) / TRIALS_PER_CYCLE
    gains = np.array([gain(waves(position, displacement / c)) for c in cycles])
    around = np.concatenate([[-np.inf], gains, [-np.inf]])
    peaks = np.flatnonzero((gains >= around[:-2]) & (gains >= around[2:]))
    best = peaks[np.argsort(-gains[peaks], kind="stable")][:n]
    return [displacement / float(cycles[i]) for i in best]


def waves(position: Array, period: float) -> Array:
    """Sine and cosine over the position, shape (samples, 2)."""
    angle = 2.0 * np.pi * position / period
    return np.column_stack([np.sin(angle), np.cos(angle)])

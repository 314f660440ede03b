"""
Periods of a force that repeats with the position, and frequencies at which a force swings in time.

Both are lines in the spectrum of a residual, over the position and over time. No other start is near enough
for a fit: all repetitions over the displacement, or the recording, have to be right to a fraction of one.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from .arrays import Array

MOST_CYCLES = 60  # over the whole displacement
TRIALS_PER_CYCLE = 2
FEWEST_SWINGS = 2  # over a recording
HIGHEST_FREQUENCY = 10.0  # Hz
MOST_SWINGS = 200  # over a recording, however long it is


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
    return [displacement / float(cycles[i]) for i in _peaks(gains)[:n]]


def likely_frequencies(times: Array, swinging: Array, gain: Callable[[Array], float], n: int) -> list[float]:
    """
    Frequencies that a residual suggests of a signal that is modulated in time, most likely first.

    Args:
        times: Within their recording [s], shape (samples,).
        swinging: The signal that is modulated, shape (samples,).
        gain: As of `likely_periods`.
        n: Number of suggestions.

    Returns:
        Frequencies [Hz] from two swings over the longest recording to 10 Hz, or to 200 swings.
    """
    duration = float(np.ptp(times))
    most = min(HIGHEST_FREQUENCY * duration, MOST_SWINGS)
    if most < FEWEST_SWINGS or not swinging.any():
        return []
    swings = np.arange(TRIALS_PER_CYCLE * FEWEST_SWINGS, TRIALS_PER_CYCLE * most + 1) / TRIALS_PER_CYCLE
    gains = np.array([gain(swinging[:, None] * waves(times, duration / s)) for s in swings])
    return [float(swings[i]) / duration for i in _peaks(gains)[:n]]


def _peaks(gains: Array) -> Array:
    """Places of local maxima, highest first."""
    around = np.concatenate([[-np.inf], gains, [-np.inf]])
    peaks = np.flatnonzero((gains >= around[:-2]) & (gains >= around[2:]))
    return np.asarray(peaks[np.argsort(-gains[peaks], kind="stable")])


def waves(position: Array, period: float) -> Array:
    """Sine and cosine over the position, or over time, shape (samples, 2)."""
    angle = 2.0 * np.pi * position / period
    return np.column_stack([np.sin(angle), np.cos(angle)])

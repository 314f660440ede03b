"""
The step of a converter, read off a residual.

A value that is rounded to steps q leaves a saw-tooth of the value with period q. The spectrum of the residual
over the value, instead of over time, has a line at 1/q. No other start is near enough for a fit, since all
steps of the range have to be right to a fraction of one.

Source: Widrow, Kollar, Quantization Noise (2008), Ch. 4 (rounding as periodic function of the value).
"""

from __future__ import annotations

import numpy as np

from .arrays import Array

LARGEST = 8.0  # step over the rms of the residual
SMALLEST = 0.5  # step over the rms of the residual
BINS_PER_STEP = 16  # of the smallest step
PADDING = 8  # of the spectrum: its lines are this much finer than the range allows
N_STEPS = 3  # suggestions
N_TRIED = 21  # steps around a line of the spectrum
MOST_STEPS = 20_000  # over the range of the value, in rms of the residual


def likely_steps(value: Array, left: Array, n: int = N_STEPS) -> list[float]:
    """
    Steps that a residual suggests, most likely first.

    Args:
        value: What may be rounded, shape (n,).
        left: Measured minus predicted, in the unit of the value, shape (n,).
        n: Number of suggestions.

    Returns:
        Steps between half the rms of the residual and eight times it; none if the value spans less than two,
        or too many for a model to be right to a fraction of one.
    """
    rms = float(np.sqrt(np.mean(left**2)))
    span = float(np.ptp(value))
    if not 2.0 * SMALLEST * rms < span < MOST_STEPS * rms:
        return []
    width = SMALLEST * rms / BINS_PER_STEP
    index = ((value - value.min()) / width).astype(int)
    over_value = np.bincount(index, weights=left - left.mean())
    power = np.abs(np.fft.rfft(over_value, PADDING * len(over_value))) ** 2
    frequency = np.fft.rfftfreq(PADDING * len(over_value), width)
    power[(frequency < max(2.0 / span, 1.0 / (LARGEST * rms))) | (frequency > 1.0 / (SMALLEST * rms))] = 0.0
    steps = []
    for _ in range(n):
        best = int(np.argmax(power))
        if power[best] <= 0.0:
            break
        near = frequency[best] + np.linspace(-0.5, 0.5, N_TRIED) * frequency[1]
        left_over = [float(np.sum((left - rounding(value, float(1.0 / f))) ** 2)) for f in near]
        steps.append(float(1.0 / near[int(np.argmin(left_over))]))
        power[max(0, best - 2 * PADDING) : best + 2 * PADDING] = 0.0
    return steps


def rounding(value: Array, step: float) -> Array:
    """What rounding to steps adds to a value, shape of the value."""
    return np.asarray(step * np.floor(value / step + 0.5) - value)

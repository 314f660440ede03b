"""Operators with memory over sampled signals: a first-order lag, and plays."""

from __future__ import annotations

import numpy as np
from scipy.signal import lfilter, lfiltic

from .arrays import Array


def lagged(values: Array, ratio: float) -> Array:
    """
    First-order lag of a signal that is linear between samples, at rest at the start.

    Args:
        values: Shape (samples,).
        ratio: Sampling period over the time constant.
    """
    q = float(np.exp(-ratio))
    numerator = [0.5 * (1.0 - q), 0.5 * (1.0 - q)]
    denominator = [1.0, -q]
    start = lfiltic(numerator, denominator, values[:1], values[:1])
    return np.asarray(lfilter(numerator, denominator, values, zi=start)[0])


def plays(position: Array, widths: Array) -> Array:
    """Play operators of half widths (m,) of a position (samples,), from zero; shape (samples, m)."""
    result = np.zeros((len(position), len(widths)))
    for k, step in enumerate(np.diff(position)):
        result[k + 1] = np.clip(result[k] + step, -widths, widths)
    return result

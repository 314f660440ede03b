"""Whether a signal moves like a model's, and at which size."""

from __future__ import annotations

import numpy as np

from .arrays import Array

ALIKE = 0.9  # correlation of signals that move alike
SMALL = 0.5  # of the largest value: where a signal is small
FEWEST = 20  # rows for a slope


def size_against(measured: Array, model: Array) -> float:
    """Size of a signal (n,) over the model's, negative if it goes the other way; 1 if they are not alike."""
    a = measured - measured.mean()
    b = model - model.mean()
    if not np.isfinite(b).all() or not np.any(a) or not np.any(b):
        return 1.0
    alike = float(a @ b / np.sqrt((a @ a) * (b @ b)))
    return float(np.sign(alike) * a.std() / b.std()) if abs(alike) > ALIKE else 1.0


def slope_of_small(measured: Array, model: Array) -> float:
    """Slope over the model where the signal (n,) is small: about 1 for one that is cut off at its largest."""
    a = measured - measured.mean()
    b = model - model.mean()
    rows = np.abs(a) < SMALL * np.abs(a).max()
    small_a = a[rows]
    small_b = b[rows]
    if len(small_b) < FEWEST or not np.any(small_b):
        return 0.0
    return float(small_a @ small_b / (small_b @ small_b))

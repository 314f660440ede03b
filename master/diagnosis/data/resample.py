"""Rows at even times from rows at others: by lines, cubic splines, the row before, or the mean."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from enum import StrEnum

import numpy as np
import scipy  # loads its packages when they are used

from master.diagnosis.numerics.arrays import Array

FOLDING = 1.5  # of the usual step: a longer period folds what is faster, unless rows are averaged
NEAR_A_ROW = 1e-6  # of the period


class Method(StrEnum):
    """How a value between rows is made."""

    LINEAR = "linear"
    CUBIC = "cubic"
    PREVIOUS = "previous"
    MEAN = "mean"


@dataclass(frozen=True)
class Resampled:
    """Signals at even times t [s], shape (n,), and what was done to how many rows."""

    t: Array
    signals: Mapping[str, Array]
    note: str


def resampled(t: Array, signals: Mapping[str, Array], period: float, method: Method) -> Resampled:
    """
    Take signals to even times from the first one on; none lies after the last.

    Args:
        t: Times [s] that grow, shape (n,).
        signals: Each of shape (n,).
        period: Distance of the new times [s].
        method: How a value between rows is made.
    """
    n = int(np.floor((t[-1] - t[0]) / period + NEAR_A_ROW)) + 1
    even = t[0] + period * np.arange(n)
    steps = np.diff(t)
    at = np.minimum(even, t[-1])
    made = {name: _at(t, values, at, method, period) for name, values in signals.items()}
    near = np.abs(t[np.clip(np.searchsorted(t, at + NEAR_A_ROW * period) - 1, 0, None)] - at)
    moved = int(np.sum(near > NEAR_A_ROW * period))
    note = (
        f"resampled ({method.value}): {len(t)} rows, {steps.min():.4g} to {steps.max():.4g} s apart, to "
        f"{n} rows every {period:.6g} s; {moved} of them between rows"
    )
    if period > FOLDING * float(np.median(steps)) and method is not Method.MEAN:
        note += f"; faster than {0.5 / period:.4g} Hz is folded, method mean averages it"
    return Resampled(even, made, note)


def _at(t: Array, values: Array, at: Array, method: Method, period: float) -> Array:
    if method is Method.CUBIC:
        return np.asarray(scipy.interpolate.CubicSpline(t, values)(at))
    if method is Method.PREVIOUS:
        return values[np.searchsorted(t, at + NEAR_A_ROW * period, side="right") - 1]
    between = np.asarray(np.interp(at, t, values))
    if method is Method.LINEAR:
        return between
    total = np.concatenate([[0.0], np.cumsum(values)])
    first = np.searchsorted(t, at - 0.5 * period, side="left")
    last = np.searchsorted(t, at + 0.5 * period, side="left")
    count = last - first
    return np.where(count > 0, (total[last] - total[first]) / np.maximum(count, 1), between)

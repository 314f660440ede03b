"""How far a prediction is from what was measured, with an interval that respects correlation."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .arrays import TINY, Array
from .whiteness import Interval, block_bootstrap, correlation_length

N_DRAWS = 300


@dataclass(frozen=True)
class Errors:
    """
    Errors of one signal; each is None where the prediction is not finite.

    `nrmse_percent` is relative to the rms of what was measured, `energy` is predicted over measured.
    """

    rmse: float | None = None
    nrmse_percent: float | None = None
    max: float | None = None
    energy: float | None = None
    rmse_interval: Interval | None = None


def errors(measured: Array, predicted: Array) -> Errors:
    """Compare a prediction with what was measured, shape (n,) each."""
    left = predicted - measured
    size = rms(measured) or 1.0
    if not np.isfinite(left).all():
        return Errors()
    return Errors(
        rmse=rms(left),
        nrmse_percent=100.0 * rms(left) / size,
        max=float(np.abs(left).max()),
        energy=float(np.sum(predicted**2) / max(np.sum(measured**2), TINY)),
        rmse_interval=block_bootstrap(rms, left, block=correlation_length(left), n_draws=N_DRAWS),
    )


def rms(values: Array) -> float:
    """Root of the mean square."""
    return float(np.sqrt(np.mean(values**2)))

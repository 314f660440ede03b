"""How much of the sealed residual's power one prediction takes away over another, with an interval."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .arrays import TINY, Array
from .whiteness import Interval, correlation_length

N_DRAWS = 400
FEWEST_BLOCKS = 12  # that are drawn from
SEED = 1


@dataclass(frozen=True)
class SealedGain:
    """Share of the power that is taken away, and its 95 % interval by a bootstrap in blocks."""

    value: float
    interval: Interval


def sealed_gain(measured: Array, before: Array, after: Array, scale: Array) -> SealedGain | None:
    """
    Compare two predictions of sealed rows.

    Args:
        measured: Shape (rows, outputs).
        before: The prediction that the other is better than, or not.
        after: The other one.
        scale: Scale of each output, shape (outputs,).

    Returns:
        None where one of them is not finite.
    """
    if not (np.isfinite(before).all() and np.isfinite(after).all()):
        return None
    old = np.sum(((before - measured) / scale) ** 2, axis=1)
    new = np.sum(((after - measured) / scale) ** 2, axis=1)
    n = len(old)
    block = max(1, min(correlation_length((before - measured)[:, 0]), n // FEWEST_BLOCKS))
    count = n // block
    old_sums = old[: count * block].reshape(count, block).sum(axis=1)
    new_sums = new[: count * block].reshape(count, block).sum(axis=1)
    draws = np.random.default_rng(SEED).integers(0, count, (N_DRAWS, count))
    shares = 1.0 - new_sums[draws].sum(axis=1) / np.maximum(old_sums[draws].sum(axis=1), TINY)
    low, high = np.quantile(shares, [0.025, 0.975])
    value = 1.0 - float(new.sum()) / max(float(old.sum()), TINY)
    return SealedGain(value, Interval(float(low), float(high)))

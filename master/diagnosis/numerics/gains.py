"""
How much better one fit is than another: gain on held-out blocks, with what chance makes of it.

    gain of block i = log(power of the base's residual / power of the candidate's)

About the share of the residual power that the candidate takes away, where that is small; every block counts
alike, whatever its amplitude. An effect that acts in a few blocks alone makes gains that differ; what chance
makes is smaller. With d the change of the prediction, e_0 and e_1 the residuals before and after,

    sum (e_0^2 - e_1^2) = sum d (d + 2 e_1),   chance: deviation of 2 sum d e_1, from the sums over blocks

and z is the one over the other.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from master.diagnosis.numerics.arrays import Array

from .least_squares import Fit, bounded

SMALLEST_GAIN, ERRORS = 0.01, 2.0


@dataclass(frozen=True)
class Gain:
    """
    Gain of a fit over the base, mean and standard error over the blocks.

    `share` is what it takes away of the whole held-out residual power, `z` that over what chance would.
    """

    fit: Fit
    mean: float
    error: float
    by_block: Array
    share: float
    z: float

    @property
    def is_accepted(self) -> bool:
        """Whether the gain is worth it and not by chance."""
        return self.mean > SMALLEST_GAIN and self.z > ERRORS


def powers(residual: Array, blocks: Sequence[slice], size: Array) -> Array:
    """Mean square of a residual (n, outputs) over its size in each block."""
    kept = [bounded(residual[block] / size) for block in blocks]
    return np.array([float(np.mean(values**2)) for values in kept])


def over(before: Fit, after: Fit, measured: Array, blocks: Sequence[slice], size: Array) -> Gain:
    """
    Gain of one fit over another on held-out blocks.

    Args:
        before: The model so far.
        after: The candidate.
        measured: Shape (n, outputs).
        blocks: Held-out rows.
        size: Scale of each output.
    """
    base, own = (powers(f.predicted - measured, blocks, size) for f in (before, after))
    taken, chance = [], []
    for block in blocks:
        e_0, e_1 = (bounded((f.predicted - measured)[block] / size) for f in (before, after))
        taken.append(float(np.sum(e_0**2) - np.sum(e_1**2)))
        chance.append(2.0 * float(np.sum((e_0 - e_1) * e_1)))
    z = sum(taken) / max(float(np.sqrt(np.sum(np.square(chance)))), 1e-300)
    return replace(gain(after, base, own), z=z)


def gain(candidate: Fit, base: Array, own: Array) -> Gain:
    """
    Compare powers of residuals in the same held-out blocks.

    Args:
        candidate: The fit that gives the powers `own`.
        base: Power of the base's residual in each block, shape (blocks,).
        own: Power of the candidate's. `z` is the mean over its standard error, see `over`.
    """
    by_block = np.log(base / own)
    error = float(by_block.std(ddof=1) / np.sqrt(len(by_block))) if len(by_block) > 1 else np.inf
    mean = float(by_block.mean())
    return Gain(
        candidate, mean, error, by_block, 1.0 - float(own.sum() / base.sum()), mean / max(error, 1e-300)
    )

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
from scipy import stats

from .arrays import TINY, Array
from .least_squares import Fit, bounded

SMALLEST_GAIN = 0.01  # mean gain below which nothing is worth a name
ERRORS = 2.0  # standard errors that a gain must exceed
ALPHA = 0.05  # chance of one false effect among all that were tried
ROUNDING = float(np.finfo(np.float64).eps) ** 2  # power of a scaled residual below which it counts as exact


@dataclass(frozen=True)
class Gain:
    """
    Gain of a fit over the base, mean and standard error over the blocks.

    `by_block` has shape (blocks,). `share` is what the fit takes away of the whole held-out residual power,
    `z` that over what chance would.
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

    @property
    def is_steady(self) -> bool:
        """Whether the gain is worth it and about alike in all blocks."""
        return self.mean > SMALLEST_GAIN and self.mean > ERRORS * self.error


def powers(residual: Array, blocks: Sequence[slice], output_scale: Array) -> Array:
    """Mean square of a residual (n, outputs) over the scale (outputs,) in each block, shape (blocks,)."""
    kept = [bounded(residual[block] / output_scale) for block in blocks]
    return np.array([float(np.mean(values**2)) for values in kept])


def gain_over(before: Fit, after: Fit, measured: Array, blocks: Sequence[slice], output_scale: Array) -> Gain:
    """
    Gain of one fit over another on held-out blocks.

    Args:
        before: The model so far.
        after: The candidate.
        measured: Shape (n, outputs).
        blocks: Held-out rows.
        output_scale: Scale of each output, shape (outputs,).
    """
    base = powers(before.predicted - measured, blocks, output_scale)
    own = powers(after.predicted - measured, blocks, output_scale)
    taken = []
    chance = []
    for block in blocks:
        e_0 = bounded((before.predicted - measured)[block] / output_scale)
        e_1 = bounded((after.predicted - measured)[block] / output_scale)
        taken.append(float(np.sum(e_0**2) - np.sum(e_1**2)))
        chance.append(2.0 * float(np.sum((e_0 - e_1) * e_1)))
    z = sum(taken) / max(float(np.sqrt(np.sum(np.square(chance)))), TINY)
    return replace(gain(after, base, own), z=z)


def gain(candidate: Fit, base: Array, own: Array) -> Gain:
    """
    Compare powers of residuals in the same held-out blocks.

    Args:
        candidate: The fit that leaves the powers `own`.
        base: Power of the base's residual in each block, shape (blocks,).
        own: Power of the candidate's. `z` is the mean over its standard error, see `gain_over`.
    """
    base = np.maximum(base, ROUNDING)
    own = np.maximum(own, ROUNDING)
    by_block = np.log(base / own)
    mean = float(by_block.mean())
    error = float(by_block.std(ddof=1) / np.sqrt(len(by_block))) if len(by_block) > 1 else np.inf
    return Gain(
        fit=candidate,
        mean=mean,
        error=error,
        by_block=by_block,
        share=1.0 - float(own.sum() / base.sum()),
        z=mean / max(error, TINY),
    )


def is_accepted(gain: Gain, n_tried: int, *, is_first: bool = True) -> bool:
    """
    Whether a gain is worth it and not the luckiest of many tries (t-test, Bonferroni over the tries).

    The first effect competes with chance. Later ones, and what is added to names, also compete with the
    faults of the models before them: all blocks have to gain about alike.
    """
    n = len(gain.by_block)
    z = gain.z if is_first else gain.mean / max(gain.error, TINY)
    is_clear = z > ERRORS and bool(stats.t.sf(z, n - 1) * n_tried < ALPHA)
    return gain.mean > SMALLEST_GAIN and is_clear


def is_worse(one: Gain, best: Gain) -> bool:
    """Whether a gain is smaller block by block, by more than the smallest gain and chance."""
    difference = best.by_block - one.by_block
    error = difference.std(ddof=1) / np.sqrt(len(difference))
    return bool(difference.mean() > max(SMALLEST_GAIN, ERRORS * error))

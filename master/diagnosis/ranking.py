"""
Which effect explains the residual: gain on held-out blocks with its standard error, forward, at most three.

    gain of block i = log(power of the base's residual / power of the candidate's)

About the share of the residual power that the candidate takes away, where that is small; every block counts
alike, whatever its amplitude. An effect that acts in a few blocks alone makes gains that differ; what chance
makes is smaller. With d the change of the prediction, e_0 and e_1 the residuals before and after,

    sum (e_0^2 - e_1^2) = sum d (d + 2 e_1),   chance: deviation of 2 sum d e_1, from the sums over blocks

and z is the one over the other. A candidate is accepted if its mean gain is above 1 % and z above two. Those
whose gain cannot be told from the best one's, block by block, form its family; if it has more than one member
the data do not name the effect.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from .fitting import Candidate, Fit, bounded, fit
from .tables import Array

SMALLEST_GAIN, ERRORS = 0.01, 2.0
AT_MOST = 3
GUARD = 200


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


@dataclass(frozen=True)
class Step:
    """One round of the forward search, best first; `family` is the best and what cannot be told from it."""

    base: Fit
    ranked: tuple[Gain, ...]
    family: tuple[str, ...]


Rows = slice | Array


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


def family(ranked: Sequence[Gain]) -> tuple[str, ...]:
    """Names that cannot be told from the first: paired difference of gains below two standard errors."""
    best = ranked[0]
    names = [best.fit.name]
    for other in ranked[1:]:
        difference = best.by_block - other.by_block
        error = difference.std(ddof=1) / np.sqrt(len(difference))
        if other.is_accepted and difference.mean() <= ERRORS * error:
            names.append(other.fit.name)
    return tuple(names)


def rank(
    base: Fit,
    candidates: Sequence[Candidate],
    measured: Array,
    in_use: Array,
    held_out: Sequence[slice],
    *,
    on_progress: Callable[[str], None] = lambda _: None,
) -> Step:
    """
    Fit every candidate and rank them by their gain over the base.

    Args:
        base: The model so far, fitted.
        candidates: Each the model so far with one more effect, all parameters free.
        measured: Shape (n, outputs).
        in_use: Rows to fit on, Boolean, shape (n,).
        held_out: Blocks of rows to judge on, apart from `in_use` by a guard.
        on_progress: Called with the name of each candidate before it is fitted.
    """
    rows = np.asarray(in_use, dtype=bool)
    size = measured[rows].std(axis=0)
    before = powers(base.predicted - measured, held_out, size)
    gains = []
    for candidate in candidates:
        on_progress(candidate.name)
        found = fit(candidate, measured, rows, size=size)
        after = powers(found.predicted - measured, held_out, size)
        gains.append(gain(found, before, after))
    ranked = tuple(sorted(gains, key=lambda g: -g.mean))
    return Step(base, ranked, family(ranked) if ranked and ranked[0].is_accepted else ())


def forward(
    base: Fit,
    extended: Callable[[tuple[str, ...]], Sequence[Candidate]],
    measured: Array,
    in_use: Array,
    held_out: Sequence[slice],
    *,
    on_progress: Callable[[str], None] = lambda _: None,
) -> list[Step]:
    """
    Add the best effect, and again, until none is accepted; the last step may have an empty family.

    `extended(chosen)` gives the candidates that have one effect more than those chosen, by candidate name.
    """
    chosen: tuple[str, ...] = ()
    steps: list[Step] = []
    for _ in range(AT_MOST):
        step = rank(base, extended(chosen), measured, in_use, held_out, on_progress=on_progress)
        steps.append(step)
        if not step.family:
            break
        base = step.ranked[0].fit
        chosen = (*chosen, base.name)
    return steps


def cross_validated(
    base: Candidate, candidate: Candidate, measured: Array, blocks: Sequence[slice], guard: int = GUARD
) -> Gain:
    """
    Gain with every block held out once and both models fitted on the others, guards left out.

    The fit in the result is that of the last block.
    """
    before: list[float] = []
    after: list[float] = []
    found = None
    for block in blocks:
        in_use = np.ones(len(measured), dtype=bool)
        in_use[max(0, block.start - guard) : block.stop + guard] = False
        size = measured[in_use].std(axis=0)
        for model, power in ((base, before), (candidate, after)):
            found = fit(model, measured, in_use, size=size)
            power.append(powers(found.predicted - measured, [block], size)[0])
    assert found is not None
    return gain(found, np.array(before), np.array(after))

"""Rows in contiguous blocks, each held out once: what may be fitted on while a block is predicted."""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from .arrays import TINY, Array, Integers, Mask
from .whiteness import Interval

N_BLOCKS = 16
N_GROUPS = 4  # every fourth block is held out together
N_DRAWS = 400
SEED = 1


class Fold(NamedTuple):
    """Rows that are predicted, those to fit on, and a split of the latter to choose a penalty by."""

    held_out: Integers
    fitted: Integers
    inner_held_out: Integers
    inner_fitted: Integers


@dataclass(frozen=True)
class Folds:
    """Contiguous blocks of rows: `block` has shape (rows,) and is -1 where a row is not used."""

    block: Integers
    guard: int

    @classmethod
    def of(cls, in_use: Mask, guard: int, n_blocks: int = N_BLOCKS) -> Folds:
        """Cut the rows in use, shape (rows,), into blocks with a guard [rows] around what is held out."""
        block = np.full(len(in_use), -1, dtype=np.int64)
        rows = np.flatnonzero(in_use)
        block[rows] = np.arange(len(rows)) * n_blocks // max(len(rows), 1)
        shortest = len(rows) // n_blocks
        return cls(block, min(guard, shortest // 4))

    @property
    def rows(self) -> Integers:
        """Rows in use."""
        return np.flatnonzero(self.block >= 0)

    def __iter__(self) -> Iterator[Fold]:
        return iter(self._folds)

    @cached_property
    def _folds(self) -> tuple[Fold, ...]:
        return tuple(self._fold(g, (g + 1) % N_GROUPS) for g in range(N_GROUPS))

    def _fold(self, group: int, inner: int) -> Fold:
        return Fold(
            held_out=self._of_groups([group]),
            fitted=self._away_from([group]),
            inner_held_out=np.flatnonzero(self._mask([inner]) & ~self._near([group])),
            inner_fitted=self._away_from([group, inner]),
        )

    def _mask(self, groups: Sequence[int]) -> Mask:
        return np.asarray((self.block >= 0) & np.isin(self.block % N_GROUPS, groups))

    def _of_groups(self, groups: Sequence[int]) -> Integers:
        return np.flatnonzero(self._mask(groups))

    def _near(self, groups: Sequence[int]) -> Mask:
        """Rows in these groups, and as near to them as the guard."""
        near = self._mask(groups)
        edges = np.flatnonzero(np.diff(near.astype(np.int8)))
        for edge in edges:
            near[max(0, edge + 1 - self.guard) : edge + 1 + self.guard] = True
        return near

    def _away_from(self, groups: Sequence[int]) -> Integers:
        return np.flatnonzero((self.block >= 0) & ~self._near(groups))


@dataclass(frozen=True)
class Share:
    """Predicted share of a residual's power on held-out rows, with its 95 % interval over the blocks."""

    value: float
    interval: Interval

    @property
    def error(self) -> float:
        """A quarter of the interval: about a standard error."""
        return 0.25 * (self.interval.high - self.interval.low)


NO_SHARE = Share(0.0, Interval(0.0, 0.0))


def share_of(residual: Array, explained: Array, block: Integers) -> Share:
    """
    Judge a prediction of a residual.

    Args:
        residual: Shape (rows,).
        explained: What was predicted while a row was held out, shape (rows,).
        block: Number of the block of each row, -1 for none, shape (rows,).
    """
    used = (block >= 0) & np.isfinite(explained) & np.isfinite(residual)
    names, index = np.unique(block[used], return_inverse=True)
    if not len(names):
        return NO_SHARE
    power = np.bincount(index, residual[used] ** 2)
    left = np.bincount(index, (residual[used] - explained[used]) ** 2)
    value = 1.0 - float(left.sum() / max(power.sum(), TINY))
    draws = np.random.default_rng(SEED).integers(0, len(names), (N_DRAWS, len(names)))
    shares = 1.0 - left[draws].sum(axis=1) / np.maximum(power[draws].sum(axis=1), TINY)
    low, high = np.quantile(shares, [0.025, 0.975])
    return Share(value, Interval(float(low), float(high)))


def cut_at(edges: Sequence[int], n: int) -> list[slice]:
    """Slices between the starts of recordings among n samples."""
    return [slice(a, b) for a, b in itertools.pairwise([*edges, n])]

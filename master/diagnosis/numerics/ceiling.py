"""
The ceiling: how much of a residual any smooth law of the slot's signals and their history could explain.

Ridge regression on random Fourier features of the standardised signals and their pasts, a Gaussian-process
regression in the limit of many features. Length scale and ridge are chosen inside the blocks that are
fitted on; the share is that of the held-out blocks, so that a residual without structure gives about zero
or less.

Source: Rahimi, Recht, Random features for large-scale kernel machines, NIPS 2007; Rasmussen, Williams,
Gaussian Processes for Machine Learning (2006), Sec. 2.2.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from .arrays import Array, Integers
from .gains import ERRORS, SMALLEST_GAIN

N_FEATURES = 200  # random Fourier features
MOST_ROWS = 3000  # rows that a regression uses
LENGTH_SCALES = (0.7, 2.0, 6.0)  # of the features, in deviations of the signals
RIDGES = (1e-3, 1e-1, 10.0, 1e3, 1e5)
N_INNER = 4  # blocks that choose length scale and ridge
GUARD = 200  # rows between what is fitted on and what is predicted


class Smoothness(NamedTuple):
    """Length scale of the features and ridge of the regression."""

    length_scale: float
    ridge: float


@dataclass(frozen=True)
class Ceiling:
    """
    Share of held-out residual power that is explained, with its standard error over the blocks.

    `explained` is the held-out prediction, shape (n,), NaN outside the blocks.
    """

    share: float
    error: float
    by_block: Array
    explained: Array

    @property
    def is_structure(self) -> bool:
        """Whether more than the smallest gain, and more than its error, is explained."""
        return self.share > SMALLEST_GAIN and self.share > ERRORS * self.error


def history(signals: Mapping[str, Array], lags: Sequence[int]) -> Array:
    """
    Signals and their pasts in columns, standardised, shape (n, signals * (1 + lags)).

    Before the start a signal has its first value.
    """
    columns = []
    for values in signals.values():
        for lag in (0, *lags):
            past = np.concatenate([np.full(lag, values[0]), values[: len(values) - lag]])
            columns.append((past - past.mean()) / (past.std() or 1.0))
    return np.column_stack(columns)


def ceiling(
    residual: Array,
    features: Array,
    blocks: Sequence[slice],
    *,
    guard: int = GUARD,
    seed: int = 1,
) -> Ceiling:
    """
    Explain a residual by anything.

    Args:
        residual: Shape (n,).
        features: Shape (n, d), see `history`.
        blocks: Contiguous blocks, each held out once.
        guard: Rows on both sides of a held-out block that are not fitted on.
        seed: Of the random features.
    """
    rng = np.random.default_rng(seed)
    directions = rng.standard_normal((features.shape[1], N_FEATURES)) / np.sqrt(features.shape[1])
    phases = rng.uniform(0.0, 2.0 * np.pi, N_FEATURES)
    maps = {s: _map(features, directions / s, phases) for s in LENGTH_SCALES}
    explained = np.full(len(residual), np.nan)
    for i, block in enumerate(blocks):
        others = [b for j, b in enumerate(blocks) if j != i]
        chosen = _chosen(residual, maps, others, guard, block)
        columns = maps[chosen.length_scale]
        rows = _rows(len(residual), [block], guard)
        weights = _weights(columns[rows], residual[rows], [chosen.ridge])[0]
        explained[block] = columns[block] @ weights
    return _pooled(residual, explained, blocks)


def _pooled(residual: Array, explained: Array, blocks: Sequence[slice]) -> Ceiling:
    """Share of the whole power, and its jackknife error over the blocks."""
    power = np.array([float(np.sum(residual[b] ** 2)) for b in blocks])
    left = np.array([float(np.sum((residual[b] - explained[b]) ** 2)) for b in blocks])
    n = len(blocks)
    share = 1.0 - float(left.sum() / power.sum())
    if n < 2:
        return Ceiling(share, np.inf, 1.0 - left / power, explained)
    without = 1.0 - (left.sum() - left) / (power.sum() - power)
    error = float(np.sqrt((n - 1) / n * np.sum((without - without.mean()) ** 2)))
    return Ceiling(share, error, 1.0 - left / power, explained)


def _chosen(
    residual: Array, maps: Mapping[float, Array], others: Sequence[slice], guard: int, block: slice
) -> Smoothness:
    """Length scale and ridge that predict some of the other blocks best, from the rest."""
    inner = others[:: max(1, len(others) // N_INNER)][:N_INNER]
    rows = _rows(len(residual), [block, *inner], guard)
    least = np.inf
    chosen = Smoothness(LENGTH_SCALES[-1], RIDGES[-1])
    for length_scale, features in maps.items():
        solutions = _weights(features[rows], residual[rows], RIDGES)
        for ridge, weights in zip(RIDGES, solutions, strict=True):
            power = sum(float(np.sum((residual[b] - features[b] @ weights) ** 2)) for b in inner)
            if power < least:
                least = power
                chosen = Smoothness(length_scale, ridge)
    return chosen


def _rows(n: int, left_out: Sequence[slice], guard: int) -> Integers:
    """Rows to fit on, thinned evenly where there are more than needed."""
    in_use = np.ones(n, dtype=bool)
    for block in left_out:
        in_use[max(0, block.start - guard) : block.stop + guard] = False
    rows = np.flatnonzero(in_use)
    return np.asarray(rows[:: max(1, len(rows) // MOST_ROWS)])


def _map(features: Array, directions: Array, phases: Array) -> Array:
    waves = np.cos(features @ directions * np.sqrt(features.shape[1]) + phases)
    return np.column_stack([waves * np.sqrt(2.0 / len(phases)), features, np.ones(len(features))])


def _weights(features: Array, residual: Array, ridges: Sequence[float]) -> list[Array]:
    """Solutions of the normal equations for several ridges, from one decomposition."""
    values, vectors = np.linalg.eigh(features.T @ features)
    target = vectors.T @ (features.T @ residual)
    return [np.asarray(vectors @ (target / (np.maximum(values, 0.0) + ridge))) for ridge in ridges]

"""Designs: points in the unit cube, one column a varied value, one row a run."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy import special
from scipy.stats import qmc

from .campaign import Design

Floats = NDArray[np.float64]


def unit_points(design: Design, n_columns: int) -> Floats:
    """
    Return the points of a sample, shape (runs, columns), each from 0 to 1.

    A point depends on the design alone, not on how many runs are made of it. Those of `saltelli` are the
    blocks A, B, A with column i of B, one after the other; see `sobol_indices`.
    """
    n = design.size or 0
    match design.method:
        case "random":
            return np.random.default_rng(design.seed).random((n, n_columns))
        case "latin_hypercube":
            return qmc.LatinHypercube(n_columns, rng=design.seed).random(n)
        case "sobol":
            return qmc.Sobol(n_columns, rng=design.seed).random(n)
        case "saltelli":
            return _saltelli(n, n_columns, design.seed)
    raise ValueError(f"no sample: {design.method}")


def _saltelli(n: int, n_columns: int, seed: int) -> Floats:
    both = qmc.Sobol(2 * n_columns, rng=seed).random(n)
    first = both[:, :n_columns]
    second = both[:, n_columns:]
    mixed = [first.copy() for _ in range(n_columns)]
    for i, block in enumerate(mixed):
        block[:, i] = second[:, i]
    return np.concatenate([first, second, *mixed])


def correlated(points: Floats, correlation: Floats) -> Floats:
    """
    Give columns of a sample the correlation of the normal variables below them (Gaussian copula).

    Raises:
        LinAlgError: If the matrix is not positive definite.
    """
    lower = np.linalg.cholesky(correlation)
    normal = special.ndtri(np.clip(points, 1e-16, 1.0 - 1e-16))
    return np.asarray(special.ndtr(normal @ lower.T))


def grid_places(counts: Sequence[int]) -> NDArray[np.int64]:
    """List all combinations of places, shape (runs, columns); the last column varies fastest."""
    if not counts:
        return np.zeros((1, 0), dtype=np.int64)
    return np.indices(tuple(counts)).reshape(len(counts), -1).T

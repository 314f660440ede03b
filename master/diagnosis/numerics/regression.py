"""Linear least squares with quadratic penalties, and with factors that must not be below a bound."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from .arrays import Array

RANK = 1e-13  # of the largest singular value: what is below is no information
RANK_OF_RESPONSES = 1e-10  # the same, for responses that are differences of replays


class Regressed(NamedTuple):
    """Power that is left (sum of squares, with the penalties) and the factors of the responses."""

    power: float
    factors: Array


def penalised(matrix: Array, left: Array, penalty: Array, centre: Array) -> Array:
    """
    Minimise |matrix x - left|^2 + (x - centre)' penalty (x - centre).

    Args:
        matrix: Shape (rows, outputs, unknowns).
        left: Shape (rows, outputs).
        penalty: Shape (unknowns, unknowns).
        centre: Shape (unknowns,).

    Returns:
        Shape (unknowns,).
    """
    a = matrix.reshape(-1, matrix.shape[2])
    normal = a.T @ a + penalty
    right = a.T @ left.ravel() + penalty @ centre
    return np.asarray(np.linalg.lstsq(normal, right, rcond=RANK)[0])


def bounded_below(
    residual: Array,
    columns: Sequence[Array],
    prior: Array,
    prior_left: Array,
    responses: Sequence[Array],
    low: Sequence[float],
) -> Regressed:
    """
    Regress a residual on columns that are free and responses whose factors have a lower bound.

    A response with a factor below its bound is left out, and its factor is zero.

    Args:
        residual: Shape (n,).
        columns: Free ones, shape (n,) each.
        prior: Square root of the penalties on them, shape (columns, columns).
        prior_left: What the penalised factors should be, shape (columns,).
        responses: Shape (n,) each.
        low: Lowest factor of each response.
    """
    n = len(columns)
    keep = list(range(len(responses)))
    target = np.concatenate([residual, prior_left])
    while True:
        matrix = np.column_stack([*columns, *(responses[i] for i in keep)] or [np.zeros_like(residual)])
        below = np.zeros((n, matrix.shape[1]))
        below[:, :n] = prior
        whole = np.vstack([matrix, below])
        solution = np.linalg.lstsq(whole, target, rcond=RANK_OF_RESPONSES)[0]
        own = solution[n : n + len(keep)]
        wrong = [i for i, factor in zip(keep, own, strict=True) if factor < low[i]]
        if not wrong:
            break
        keep = [i for i in keep if i not in wrong]
    factors = np.zeros(len(responses))
    factors[keep] = own
    left = target - whole @ solution
    return Regressed(float(left @ left), factors)

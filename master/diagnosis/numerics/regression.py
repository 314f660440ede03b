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


class Background:
    """
    What a residual is regressed on in any case, decomposed once for all responses that are tried with it.

    Args:
        residual: Shape (n,).
        columns: Free ones, shape (n,) each.
        prior: Square root of the penalties on them, shape (columns, columns).
        prior_left: What the penalised factors should be, shape (columns,).
    """

    def __init__(self, residual: Array, columns: Sequence[Array], prior: Array, prior_left: Array) -> None:
        target = np.concatenate([residual, prior_left])
        whole = np.vstack([np.column_stack(columns), prior]) if columns else np.zeros((len(target), 0))
        left, sizes, _ = np.linalg.svd(whole, full_matrices=False)
        self.basis = left[:, sizes > RANK_OF_RESPONSES * sizes.max(initial=0.0)]
        self.n = len(residual)
        self.target = target - self.basis @ (self.basis.T @ target)
        self.power = float(self.target @ self.target)

    def regressed(self, responses: Sequence[Array], low: Sequence[float]) -> Regressed:
        """
        Regress on responses, shape (n,) each, whose factors have a lower bound.

        A response with a factor below its bound is left out, and its factor is zero.
        """
        factors = np.zeros(len(responses))
        own = [self._without_background(r) for r in responses]
        keep = list(range(len(responses)))
        while keep:
            matrix = np.column_stack([own[i] for i in keep])
            found = np.linalg.lstsq(matrix.T @ matrix, matrix.T @ self.target, rcond=RANK)[0]
            wrong = [i for i, factor in zip(keep, found, strict=True) if factor < low[i]]
            if not wrong:
                left = self.target - matrix @ found
                factors[keep] = found
                return Regressed(float(left @ left), factors)
            keep = [i for i in keep if i not in wrong]
        return Regressed(self.power, factors)

    def _without_background(self, response: Array) -> Array:
        """What the free columns cannot make of a response; nothing where that is rounding."""
        rest = -self.basis @ (self.basis[: self.n].T @ response)
        rest[: self.n] += response
        is_rounding = rest @ rest <= RANK_OF_RESPONSES**2 * (response @ response)
        return np.zeros_like(rest) if is_rounding else rest

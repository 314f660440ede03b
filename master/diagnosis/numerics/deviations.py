"""
Deviations of fitted numbers that hold where the residual is coloured.

    covariance = H^-1 S H^-1,   H = J'J with the priors,   S = sum over blocks of s s',   s = J_b' r_b

with blocks longer than the residual's correlation: neighbouring rows say less than independent ones. The
inverse of H alone, which takes the residual as white, is several times too small. Few blocks know their own
spread badly: deviations are widened so that 1.96 of them hold as a t-interval does. What no row depends on is
not known at all: its deviation is infinite.

Source: White, Econometrica 50 (1982) 1; Newey, West, Econometrica 55 (1987) 703 (dependent rows).
"""

from __future__ import annotations

import numpy as np
import scipy  # loads its packages when they are used

from .arrays import TINY, Array, Mask
from .whiteness import correlation_length

FEWEST_BLOCKS = 12
NORMAL = 1.959963984540054  # deviations of a 95 % interval
UNSEEN = 1e-13  # eigenvalue of J'J with columns of length 1, along which no row depends on the unknowns
PART = 1e-3  # of such a direction: an unknown with less is no part of it


def sandwich(jacobian: Array, residual: Array, n_outputs: int, n_priors: int) -> Array:
    """
    Covariance of unknowns at the least-squares solution.

    Args:
        jacobian: Shape (rows * outputs + priors, unknowns).
        residual: Scaled, shape (rows * outputs + priors,).
        n_outputs: Number of outputs of a row.
        n_priors: Number of priors at the end, whose residual has the deviation 1.

    Returns:
        Shape (unknowns, unknowns).
    """
    covariance = _of_seen(jacobian, residual, n_outputs, n_priors)
    unseen = _unseen(jacobian)
    covariance[unseen, unseen] = np.inf
    return covariance


def _unseen(jacobian: Array) -> Mask:
    """Which unknowns no row depends on, alone or as part of a combination; shape (unknowns,)."""
    lengths = np.linalg.norm(jacobian, axis=0)
    longest = lengths.max(initial=0.0)
    is_dead = lengths <= TINY * max(longest, 1.0)
    unit = jacobian / np.where(is_dead, 1.0, lengths)
    eigenvalues, directions = np.linalg.eigh(unit.T @ unit)
    free = np.abs(directions[:, eigenvalues < UNSEEN]).max(axis=1, initial=0.0)
    return np.asarray(is_dead | (free > PART))


def _of_seen(jacobian: Array, residual: Array, n_outputs: int, n_priors: int) -> Array:
    """The covariance where all unknowns are seen; 0 for what no row depends on."""
    n = len(residual) - n_priors
    inverse = np.linalg.pinv(jacobian.T @ jacobian)
    rows = n // n_outputs
    first = residual[:n].reshape(rows, n_outputs)
    loudest = int(np.argmax(np.mean(first**2, axis=0)))
    block = max(1, min(correlation_length(first[:, loudest]), rows // FEWEST_BLOCKS))
    count = rows // block
    if count < 2:
        return np.asarray(inverse * float(residual @ residual) / max(1, n - jacobian.shape[1]))
    scores = jacobian[:n] * residual[:n, None]
    sums = scores[: count * block * n_outputs].reshape(count, block * n_outputs, -1).sum(axis=1)
    sums = sums - sums.mean(axis=0)
    freedom = max(3, count - jacobian.shape[1])
    wider = (float(scipy.stats.t.ppf(0.975, freedom)) / NORMAL) ** 2
    middle = sums.T @ sums * (rows / (count * block)) * wider * count / freedom
    priors = jacobian[n:]
    return np.asarray(inverse @ (middle + priors.T @ priors) @ inverse)

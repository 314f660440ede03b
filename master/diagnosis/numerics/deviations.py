"""
Deviations of fitted numbers that hold where the residual is coloured.

    covariance = H^-1 S H^-1,   H = J'J with the priors,   S = sum over blocks of s s',   s = J_b' r_b

with blocks longer than the residual's correlation: neighbouring rows say less than independent ones. The
inverse of H alone, which takes the residual as white, is several times too small. Few blocks know their own
spread badly: deviations are widened so that 1.96 of them hold as a t-interval does.

Source: White, Econometrica 50 (1982) 1; Newey, West, Econometrica 55 (1987) 703 (dependent rows).
"""

from __future__ import annotations

import numpy as np
import scipy  # loads its packages when they are used

from .arrays import Array
from .whiteness import correlation_length

FEWEST_BLOCKS = 12
NORMAL = 1.959963984540054  # deviations of a 95 % interval


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

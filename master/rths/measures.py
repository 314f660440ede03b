"""
The nine measures of the benchmark, as its code computes them.

With t the target (floor 1 of the numerical part), x_m the measured displacement, r_i floor i of the undivided
building, x_i floor i of the hybrid test, sd the standard deviation:

    J1    lag of x_m on t with the largest correlation, 0 to 49 samples                         [ms]
    J2    sd(x_m - t)/sd(t)                         J3    max|x_m - t|/max|t|                   [%]
    J4    sd(x_m - r_1)/sd(r_1)                     J5    max|x_m - r_1|/max|r_1|               [%]
    J6    sd(x_2 - r_2)/sd(r_2)                     J7    sd(x_3 - r_3)/sd(r_3)                 [%]
    J8    max|x_2 - r_2|/max|r_2|                   J9    max|x_3 - r_3|/max|r_3|               [%]

The definition paper numbers J5 to J9 otherwise and has rms for sd; its Table 3 is by the code.
Source: Silva, Gomez, Maghareh, Dyke, Spencer, Mech. Syst. Signal Process. 135 (2020), package V23.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

LARGEST_LAG = 49
AT_REST = 1e-12  # of the variance of all: what rounding leaves of none
"""Largest lag that the correlation looks at [samples]."""
N_MEASURES = 9


@dataclass(frozen=True)
class Motions:
    """Rows of a run, shape (rows,) or (rows, 3) [m]: numerical floors, measured floor 1, whole building."""

    floors: Floats
    measured: Floats
    reference: Floats


def measures(motions: Motions, step_size: float) -> list[float]:
    """Return J1 [ms] to J9 [%] of rows that are `step_size` [s] apart."""
    target = motions.floors[:, 0]
    x_m, reference = motions.measured, motions.reference
    second, third = motions.floors[:, 1], motions.floors[:, 2]
    return [
        1e3 * step_size * lag(x_m, target),
        spread(x_m, target),
        peak(x_m, target),
        spread(x_m, reference[:, 0]),
        peak(x_m, reference[:, 0]),
        spread(second, reference[:, 1]),
        spread(third, reference[:, 2]),
        peak(second, reference[:, 1]),
        peak(third, reference[:, 2]),
    ]


def lag(late: Floats, early: Floats) -> int:
    """
    Return the lag with the largest correlation (Pearson) [samples].

    Sums over what is left after a lag are those of the whole less those of the few samples at one end. A lag
    after which one of the two does not move any more says nothing.
    """
    late = late - late.mean()
    early = early - early.mean()
    n = len(late)
    all_a = _product(late, late)
    all_b = _product(early, early)
    best = -math.inf
    found = 0
    for i in range(min(LARGEST_LAG + 1, n - 1)):
        left = n - i
        a = late[i:]
        b = early[:left]
        sum_a = -late[:i].sum()
        sum_b = -early[left:].sum()
        square_a = all_a - _product(late[:i], late[:i])
        square_b = all_b - _product(early[left:], early[left:])
        variance_a = square_a - sum_a * sum_a / left
        variance_b = square_b - sum_b * sum_b / left
        if variance_a <= AT_REST * all_a or variance_b <= AT_REST * all_b:
            continue
        correlation = (_product(a, b) - sum_a * sum_b / left) / math.sqrt(variance_a * variance_b)
        if correlation > best:
            best = correlation
            found = i
    return found


def spread(signal: Floats, reference: Floats) -> float:
    """Return the standard deviation of the difference in terms of that of the reference [%]."""
    return spread_of(signal - reference, reference)


def spread_of(difference: Floats, reference: Floats) -> float:
    """Return the standard deviation of a difference in terms of that of the reference [%]."""
    return 100.0 * float(np.std(difference, ddof=1) / np.std(reference, ddof=1))


def peak(signal: Floats, reference: Floats) -> float:
    """Return the largest difference in terms of the largest value of the reference [%]."""
    return 100.0 * float(np.max(np.abs(signal - reference)) / np.max(np.abs(reference)))


def _product(a: Floats, b: Floats) -> float:
    """Return the sum of products; the threads of a BLAS product take more time than the sum."""
    return float(np.einsum("i,i", a, b))

"""
The one fixed-step scheme of all continuous models: classical Runge-Kutta of order 4 in substeps.

    k1 = f(0), k2 = f(h/2, k1), k3 = f(h/2, k2), k4 = f(h, k3)
    x  = x + h/6 (k1 + 2 k2 + 2 k3 + k4)

The native flavour does the same operations in the same order, so that both agree bit for bit.
Source: Hairer, Norsett, Wanner, Solving Ordinary Differential Equations I, Sec. II.1, Table 1.2.
"""

from __future__ import annotations

import math
from collections.abc import Callable

MOST_SAMPLES = 10_000
"""Sampling periods that a communication step may hold: more is a wrong number, and takes for ever."""

MOST_SUBSTEPS = 1_000_000
"""Substeps that a communication step may take, in all its sampling periods."""

RightHandSide = Callable[[float, list[float]], list[float]]


def n_substeps(step: float, longest: float) -> int:
    """Count the equal substeps that a step [s] is cut into, none longer than `longest` [s]."""
    return max(1, math.ceil(step / longest - 1e-9))


def runge_kutta_4(f: RightHandSide, n: int, x: list[float]) -> list[float]:
    """
    Integrate n substeps.

    Args:
        f: `f(i, x)` gives h * der(x), shape of x, at place i counted in substeps (i = 0, 0.5, 1, ...).
        n: Number of substeps.
        x: States at place 0.
    """
    for i in range(n):
        k1 = f(i, x)
        k2 = f(i + 0.5, [a + 0.5 * b for a, b in zip(x, k1, strict=True)])
        k3 = f(i + 0.5, [a + 0.5 * b for a, b in zip(x, k2, strict=True)])
        k4 = f(i + 1.0, [a + b for a, b in zip(x, k3, strict=True)])
        x = [a + (b + 2.0 * c + 2.0 * d + e) / 6.0 for a, b, c, d, e in zip(x, k1, k2, k3, k4, strict=True)]
    return x

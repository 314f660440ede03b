"""
Recursive least squares with forgetting, the identifier that the paper holds against the Kalman filter.

    K = P H'/(lambda + H P H')
    Y = Y + K (Z - H Y)
    P = (P - K H P)/lambda

With P/lambda taken before the measurement this is the Kalman filter with R = 1:

    P = P/lambda,   K = P H'/(1 + H P H'),   P = P - K H P

Source   Paper, Sec. V-A.3; Ljung, System Identification, 2nd ed., Sec. 11.2 (forgetting factor).
Deviation  P is not enlarged beyond LARGEST_TRACE: without excitation it grows without bound.
"""

from __future__ import annotations

from typing import Any

from ..framework.arithmetic import Arithmetic
from .kalman import DIAGONAL

R = 1.0
LARGEST_TRACE = 1e15


def forgetting(P: tuple[Any, ...], forgetting_factor: Any, m: Arithmetic) -> Any:
    """Give the factor 1/lambda, or 1 for a P that is large already."""
    trace = sum(P[i] for i in DIAGONAL)
    return m.where(trace < LARGEST_TRACE, 1.0 / forgetting_factor, 1.0)


def predicted(P: tuple[Any, ...], factor: Any) -> tuple[Any, ...]:
    """Give P/lambda."""
    return tuple(element * factor for element in P)

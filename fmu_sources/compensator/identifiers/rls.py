"""
Recursive least squares with forgetting, the identifier with which the paper compares the Kalman filter.

    K = P H'/(lambda + H P H')
    Y = Y + K (Z - H Y)
    P = (P - K H P)/lambda

With P/lambda taken before the measurement this is the recursion with Q = 0 and R = 1:

    P = P/lambda,   K = P H'/(1 + H P H'),   P = P - K H P

Parameters forgetting_factor lambda in 0..1
Source     Paper, Sec. V-A.3; Ljung, System Identification, 2nd ed., Sec. 11.2 (forgetting factor).
Deviation  P is not enlarged beyond LARGEST_TRACE: without excitation it grows without bound.
"""

from __future__ import annotations

from typing import Any

from ...framework.arithmetic import Arithmetic
from ...framework.variables import parameter
from ..tuning import Tuning
from .framework.identifier import Identifier, Vector
from .framework.recursion import DIAGONAL, Settings

R = 1.0
LARGEST_TRACE = 1e15


def forgetting(P: Vector, forgetting_factor: Any, m: Arithmetic) -> Any:
    """Return the factor 1/lambda, or 1 for a P that is large already."""
    trace = sum(P[i] for i in DIAGONAL)
    return m.where(trace < LARGEST_TRACE, 1.0 / forgetting_factor, 1.0)


def settings(P: Vector, chosen: Tuning, p: Any, m: Arithmetic) -> Settings:
    """Return the forgetting, relative to a noise of variance 1."""
    return Settings(forgetting(P, p.forgetting_factor, m), 0.0, 0.0, R)


IDENTIFIER = Identifier(
    name="rls",
    number=2,
    held_by="identification_held",
    settings=settings,
    parameters=(
        parameter("forgetting_factor", 0.995, "1", "Forgetting factor of rls", above=0.0, maximum=1.0),
    ),
)

"""
A force that repeats along the way: cogging, a screw's pitch.

    F = value + A sin(2 pi r / L) + B cos(2 pi r / L)

Parameters sine A [N], cosine B [N], period L [m] > 0
Source     Fourier series of a periodic force, first term; Tan, Huang, Lee, IEEE Trans. Control Syst. Technol.
           10 (2002) 594 (force ripple).
"""

from __future__ import annotations

from typing import Any

from ..framework.arithmetic import Arithmetic
from ..framework.variables import parameter
from .framework.effect import MECHANICAL, Applied, Effect, FirstGuess


def law(t: Any, value: Any, s: Any, x: Any, p: Any, m: Arithmetic) -> Applied:
    """Add a force that repeats along the way."""
    angle = 2.0 * m.pi * s.position / p.period
    return Applied(value + p.sine * m.sin(angle) + p.cosine * m.cos(angle))


EFFECT = Effect(
    name="ripple",
    description="A force that repeats along the way",
    law=law,
    parameters=(
        parameter("sine", 0.0, "{value}", "Odd part A"),
        parameter("cosine", 0.0, "{value}", "Even part B"),
        parameter("period", 0.01, "{position}", "Length of the period L", above=0.0),
    ),
    absent={"sine": 0.0, "cosine": 0.0},
    scale=lambda rms: {"sine": 0.05 * rms.value, "cosine": 0.05 * rms.value, "period": 0.5 * rms.position},
    needs=("position",),
    places=MECHANICAL,
    first_guess=FirstGuess.PERIODS,
)

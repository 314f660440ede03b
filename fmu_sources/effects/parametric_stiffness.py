"""
A stiffness that swings in time, at a frequency of its own.

    F = value + r (A sin(2 pi f t) + B cos(2 pi f t))

Parameters sine A, cosine B [{value}/{position}], frequency f [Hz] > 0
Source     Mathieu's equation; Nayfeh, Mook, Nonlinear Oscillations (1979), Sec. 5.1.
Limits     A period much longer than the recording is a stiffness that drifts.
"""

from __future__ import annotations

from typing import Any

from ..framework.arithmetic import Arithmetic
from ..framework.variables import parameter
from .framework.effect import MECHANICAL, Applied, Effect, FirstGuess


def law(t: Any, value: Any, s: Any, x: Any, p: Any, m: Arithmetic) -> Applied:
    """Add a spring whose stiffness swings around zero."""
    angle = 2.0 * m.pi * p.frequency * t
    return Applied(value + s.position * (p.sine * m.sin(angle) + p.cosine * m.cos(angle)))


EFFECT = Effect(
    name="parametric_stiffness",
    description="A stiffness that swings in time",
    law=law,
    parameters=(
        parameter("sine", 0.0, "{value}/{position}", "Swing in phase with the start A"),
        parameter("cosine", 0.0, "{value}/{position}", "Swing a quarter of a period later B"),
        parameter("frequency", 1.0, "Hz", "Frequency f", above=0.0),
    ),
    absent={"sine": 0.0, "cosine": 0.0},
    scale=lambda rms: {
        "sine": 0.05 * rms.value / rms.position,
        "cosine": 0.05 * rms.value / rms.position,
        "frequency": 10.0 / rms.duration,
    },
    needs=("position",),
    places=MECHANICAL,
    first_guess=FirstGuess.FREQUENCIES,
    of_class="periodic in time",
)

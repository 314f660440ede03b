"""
A value in steps.

    y = q floor(value / q + 1/2);   q = 0 leaves the value

Parameters step q [{value}] >= 0
Source     analogue-to-digital conversion, rounding to the nearest step.
"""

from __future__ import annotations

from typing import Any

from ..framework.arithmetic import Arithmetic
from ..framework.variables import parameter
from .framework.effect import SIGNAL, Applied, Effect, FirstGuess


def law(t: Any, value: Any, s: Any, x: Any, p: Any, m: Arithmetic) -> Applied:
    """Round to steps."""
    is_on = p.step > 0.0
    step = m.where(is_on, p.step, 1.0)
    return Applied(m.where(is_on, step * m.floor(value / step + 0.5), value))


EFFECT = Effect(
    name="quantisation",
    description="A value in steps",
    law=law,
    parameters=(parameter("step", 0.0, "{value}", "Step q", minimum=0.0),),
    absent={"step": 0.0},
    scale=lambda rms: {"step": 0.02 * rms.value},
    places=SIGNAL,
    first_guess=FirstGuess.QUANTA,
)

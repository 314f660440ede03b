"""
A wrong gain.

    y = (1 + eps) value

Parameters error eps [1]
Source     calibration of a sensor.
Limits     Cannot be told from the stiffness and damping of the contact when those are refitted.
"""

from __future__ import annotations

from typing import Any

from ..framework.arithmetic import Arithmetic
from ..framework.variables import parameter
from .framework.effect import SIGNAL, Applied, Effect
from .framework.experiment import Experiment


def law(t: Any, value: Any, s: Any, x: Any, p: Any, m: Arithmetic) -> Applied:
    """Scale the value."""
    return Applied(value + p.error * value)


EFFECT = Effect(
    name="gain_error",
    description="A wrong gain",
    law=law,
    parameters=(parameter("error", 0.0, "1", "Relative error of the gain eps", minimum=-0.9),),
    absent={"error": 0.0},
    scale=lambda _: {"error": 0.05},
    places=SIGNAL,
    shown_by=(Experiment.CHIRP,),
    of_class="gain",
)

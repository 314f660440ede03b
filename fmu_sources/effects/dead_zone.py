"""
A value that is nothing within a band around zero, and less by the band outside.

    y = value - clip(value, -d, d)

Parameters width d [{value}] >= 0, half of the band
Source     dead zone of a valve or an amplifier; Tao, Kokotovic, IEEE Trans. Autom. Control 39 (1994) 59.
Limits     Where the value never leaves the band, nothing is left of it.
"""

from __future__ import annotations

from typing import Any

from ..framework.arithmetic import Arithmetic
from ..framework.variables import parameter
from .framework.effect import SIGNAL, Applied, Effect
from .framework.experiment import Experiment
from .framework.shapes import dead_zone


def law(t: Any, value: Any, s: Any, x: Any, p: Any, m: Arithmetic) -> Applied:
    """Take away what is within the band."""
    return Applied(dead_zone(value, p.width, m))


EFFECT = Effect(
    name="dead_zone",
    description="A value that is nothing near zero",
    law=law,
    parameters=(parameter("width", 0.0, "{value}", "Half of the band d", minimum=0.0),),
    absent={"width": 0.0},
    scale=lambda rms: {"width": 0.05 * rms.value},
    places=SIGNAL,
    shown_by=(Experiment.OTHER_AMPLITUDE,),
)

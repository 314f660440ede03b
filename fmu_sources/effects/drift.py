"""
A value that runs away with time, from t = 0.

    y = value + b' t

Parameters rate b' [{value}/s]
Source     thermal drift of an amplifier, to first order.
"""

from __future__ import annotations

from typing import Any

from ..framework.arithmetic import Arithmetic
from ..framework.variables import parameter
from .framework.effect import SIGNAL, Applied, Effect
from .framework.experiment import Experiment


def law(t: Any, value: Any, s: Any, x: Any, p: Any, m: Arithmetic) -> Applied:
    """Add a ramp."""
    return Applied(value + p.rate * t)


EFFECT = Effect(
    name="drift",
    description="A value that runs away with time",
    law=law,
    parameters=(parameter("rate", 0.0, "{value}/s", "Drift per second b'"),),
    absent={"rate": 0.0},
    scale=lambda rms: {"rate": 0.05 * rms.value / rms.duration},
    places=SIGNAL,
    shown_by=(Experiment.LONG_REST,),
    of_class="zero error",
)

"""
A value that drifts towards another one as its amplifier warms up, from t = 0.

    y = value + A (1 - exp(-t / tau))

Parameters amplitude A [{value}], time_constant tau [s] > 0
Source     thermal transient of first order after power is switched on.
Limits     A long time constant is `drift` at A / tau, a short one `offset`.
"""

from __future__ import annotations

from typing import Any

from ..framework.arithmetic import Arithmetic
from ..framework.variables import parameter
from .framework.effect import SIGNAL, Applied, Effect
from .framework.experiment import Experiment
from .framework.limit import Limit


def law(t: Any, value: Any, s: Any, x: Any, p: Any, m: Arithmetic) -> Applied:
    """Add an offset that builds up."""
    return Applied(value + p.amplitude * (1.0 - m.exp(-t / p.time_constant)))


EFFECT = Effect(
    name="warm_up",
    description="A value that drifts towards another one",
    law=law,
    parameters=(
        parameter("amplitude", 0.0, "{value}", "Offset in the end A"),
        parameter("time_constant", 100.0, "s", "Time constant tau", above=0.0),
    ),
    absent={"amplitude": 0.0},
    scale=lambda rms: {"amplitude": 0.05 * rms.value, "time_constant": 0.3 * rms.duration},
    places=SIGNAL,
    shown_by=(Experiment.LONG_REST,),
    of_class="zero error",
    limits=(
        Limit(
            becomes="drift",
            is_reached=lambda p, rms: p["time_constant"] > 10.0 * rms.duration,
            because="it hardly bends within the recording",
            values=lambda p: {"rate": p["amplitude"] / p["time_constant"]},
        ),
        Limit(
            becomes="offset",
            is_reached=lambda p, rms: p["time_constant"] < 1e-3 * rms.duration,
            because="it is over as the recording begins",
            values=lambda p: {"offset": p["amplitude"]},
        ),
    ),
)

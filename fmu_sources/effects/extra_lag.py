"""
A lag of first order on the way.

    T_c z' = value - z,   y = value + T / T_c (z - value),   T_c = max(T, T_min)

For T >= T_min this is y = value / (1 + T s). Below, the pole stays at 1/T_min for the integrator and the
delay at low frequency is still T; T = 0 leaves the value.

Parameters time_constant T [s] >= 0
Source     definition of a first-order lag.
Limits     Where the value is held over a sampling period, half a period more.
"""

from __future__ import annotations

from typing import Any

from ..framework.arithmetic import Arithmetic
from ..framework.variables import parameter, state
from .framework.effect import SIGNAL, Applied, Effect
from .framework.experiment import Experiment
from .framework.shapes import larger

T_MIN = 0.5e-3


def law(t: Any, value: Any, s: Any, x: Any, p: Any, m: Arithmetic) -> Applied:
    """Let the value lag."""
    t_c = larger(p.time_constant, T_MIN, m)
    behind = x.lagged - value
    return Applied(value + p.time_constant / t_c * behind, {"lagged": -behind / t_c})


EFFECT = Effect(
    name="extra_lag",
    description="A lag of first order",
    law=law,
    parameters=(parameter("time_constant", 0.0, "s", "Time constant T", minimum=0.0, maximum=1.0),),
    states=(state("lagged", "{value}", "Lagged value z"),),
    absent={"time_constant": 0.0},
    scale=lambda _: {"time_constant": 2e-3},
    places=SIGNAL,
    follows=("lagged",),
    acts_like="lag",
    shown_by=(Experiment.CHIRP,),
)

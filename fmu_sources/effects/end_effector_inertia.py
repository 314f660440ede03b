"""
A mass between the contact and the sensor: the sensor also feels its acceleration.

    y = value + a w,   w = value'' behind a filter 1 / (1 + T_d s)^2,   T_d = 1 ms

With the contact force -k_m x_e of a spring, x_e'' = -value'' / k_m: a mass m_x gives a = -m_x / k_m for
a force f = -k_m x_e + m_x x_e''.

    z_1' = z_2,   z_2' = (value - z_1 - 2 T_d z_2) / T_d^2,   w = z_2'

Parameters ratio a [s^2]
Source     D'Alembert's force of the carried mass.
Limits     The filter bends the acceleration above about 50 Hz.
"""

from __future__ import annotations

from typing import Any

from ..framework.arithmetic import Arithmetic
from ..framework.variables import parameter, state
from .framework.effect import SIGNAL, Applied, Effect
from .framework.experiment import Experiment

T_D = 1e-3


def law(t: Any, value: Any, s: Any, x: Any, p: Any, m: Arithmetic) -> Applied:
    """Add the force that accelerates the carried mass."""
    second = (value - x.filtered - 2.0 * T_D * x.rate) / (T_D * T_D)
    return Applied(value + p.ratio * second, {"filtered": x.rate, "rate": second})


EFFECT = Effect(
    name="end_effector_inertia",
    description="A mass between contact and sensor",
    law=law,
    parameters=(
        parameter("ratio", 0.0, "s2", "Mass over stiffness, with sign a", minimum=-1e-2, maximum=1e-2),
    ),
    states=(
        state("filtered", "{value}", "Filtered value z_1"),
        state("rate", "{value}/s", "Rate of the filtered value z_2"),
    ),
    absent={"ratio": 0.0},
    scale=lambda _: {"ratio": 2e-5},
    places=SIGNAL,
    follows=("filtered",),
    acts_like="lag",
    shown_by=(Experiment.CHIRP,),
)

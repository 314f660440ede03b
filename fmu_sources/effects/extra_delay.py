"""
A dead time on the way, by a rational function of order 2.

    y / value = (1 + n_1 s + n_2 s^2) / (1 + d_1 s + d_2 s^2)
    d_1 = T_c/2,  d_2 = T_c^2/12,  T_c = max(T, T_min),  n_1 = d_1 - T,  n_2 = d_2 - T d_1 + T^2/2

For T >= T_min this is the Pade approximant of exp(-T s), wrong by (T s)^5/720. Below, the poles stay for the
integrator and the numerator keeps delay and curvature right; T = 0 leaves the value.

    z_1' = z_2,   d_2 z_2' = value - z_1 - d_1 z_2,   y = z_1 + n_1 z_2 + n_2 z_2'

Parameters dead_time T [s] >= 0
Source     Golub, Van Loan, Matrix Computations (2013), Sec. 9.3.1 (Pade approximants of exp).
Limits     Signals with T s below about 1: 30 Hz at 5 ms.
"""

from __future__ import annotations

from typing import Any

from ..framework.arithmetic import Arithmetic
from ..framework.variables import parameter, state
from .framework.effect import SIGNAL, Applied, Effect
from .framework.experiment import Experiment
from .framework.shapes import larger

T_MIN = 1e-3


def law(t: Any, value: Any, s: Any, x: Any, p: Any, m: Arithmetic) -> Applied:
    """Delay the value."""
    t_c = larger(p.dead_time, T_MIN, m)
    d1, d2 = t_c / 2.0, t_c * t_c / 12.0
    n1, n2 = d1 - p.dead_time, d2 - p.dead_time * d1 + 0.5 * p.dead_time * p.dead_time
    der_rate = (value - x.filtered - d1 * x.rate) / d2
    delayed = value + (n1 - d1) * x.rate + (n2 - d2) * der_rate
    return Applied(delayed, {"filtered": x.rate, "rate": der_rate})


EFFECT = Effect(
    name="extra_delay",
    description="A dead time",
    law=law,
    parameters=(parameter("dead_time", 0.0, "s", "Dead time T", minimum=0.0, maximum=0.1),),
    states=(
        state("filtered", "{value}", "Filtered value z_1"),
        state("rate", "{value}/s", "Rate of the filtered value z_2"),
    ),
    absent={"dead_time": 0.0},
    scale=lambda _: {"dead_time": 2e-3},
    places=SIGNAL,
    follows=("filtered",),
    acts_like="lag",
    shown_by=(Experiment.CHIRP,),
)

"""
Polynomial extrapolation of the desired displacement over the delay of the motion simulator.

    s_cmd = s(t + delta) = 4 s(t) - 6 s(t - delta) + 4 s(t - 2 delta) - s(t - 3 delta)
    delta = round(lag/T) T;   f_comp = f_mea + T_f_hat f_mea', backward difference

Inputs   s_des, s_act, x [m], f_mea [N], v_des [m/s], a_des [m/s2]      used: s_des, f_mea
Outputs  f_comp [N], s_cmd [m]
States   f_comp, s_cmd, last_f_mea, line[i]: s_des of i periods ago   start: steady in the inputs
Source   Horiuchi, Inoue, Konno, Namita, Real-time hybrid experimental system with actuator delay
         compensation,
         Earthquake Eng. Struct. Dyn. 28 (1999): third-order polynomial through points delta apart.
Valid    A pure delay of at most 60 periods, motion with w delta below about 1. Until 3 delta have passed the
         polynomial goes through the start value, which was not moving.
"""

from __future__ import annotations

from typing import Any

from ..framework.arithmetic import Arithmetic
from ..framework.model import Model, SlotFunction, Values, no_effect
from ..framework.variables import declare, parameter, sampled, state, vector
from .plant import T_F_HAT, led_force
from .plugs import INPUTS, OUTPUTS, SAMPLE_TIME, TERMINALS

LONGEST = 60
"""Longest delay in periods."""


class Horiuchi(Model):
    """Displacement method: polynomial of third order."""

    name = "horiuchi"
    description = "Polynomial extrapolation of the desired displacement"
    variables = declare(
        parameter("lag", 0.0355, "s", "Believed lag, rounded to periods, at most 60", minimum=0.0),
        T_F_HAT,
        SAMPLE_TIME,
        INPUTS,
        OUTPUTS,
        sampled(state("last_f_mea", "N", "Measured force, k-1"), hidden=True),
        vector(
            sampled(state("line", "m", "Desired displacement of earlier periods"), hidden=True), 3 * LONGEST
        ),
    )
    terminals = TERMINALS
    sample_time = "sample_time"

    def initial(self, x: Any, u: Any, p: Any, m: Arithmetic) -> Values:
        line = (u.s_des,) * (3 * LONGEST)
        return {"f_comp": u.f_mea, "s_cmd": u.s_des, "last_f_mea": u.f_mea, "line": line}

    def update(self, t: Any, x: Any, u: Any, p: Any, m: Arithmetic, slot: SlotFunction = no_effect) -> Values:
        n = m.floor(p.lag / p.sample_time + 0.5)
        line = (u.s_des, *x.line)
        once = m.pick(line[: LONGEST + 1], n)
        twice = m.pick(line[: 2 * LONGEST + 1 : 2], n)
        thrice = m.pick(line[: 3 * LONGEST + 1 : 3], n)
        s_cmd = u.s_des + 3.0 * (u.s_des - once) - 3.0 * (once - twice) + (twice - thrice)  # rest stays rest
        return {"f_comp": led_force(x, u, p), "s_cmd": s_cmd, "last_f_mea": u.f_mea, "line": line[:-1]}


MODEL = Horiuchi()

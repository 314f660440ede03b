"""
First-order inverse of the motion simulator on its command.

    believed: s_act(k) = s_act(k-1) + (s_cmd(k) - s_act(k-1))/alpha,   alpha = 1 + lag/T
    s_cmd(k) = alpha s_des(k) - (alpha - 1) s_des(k-1)
    f_comp   = f_mea + T_f_hat f_mea',   backward difference

Inputs   s_des, s_act, x [m], f_mea [N], v_des [m/s], a_des [m/s2]      used: s_des, f_mea
Outputs  f_comp [N], s_cmd [m]
States   f_comp, s_cmd, last_f_mea, last_s_des   start: steady in the inputs
Source   Chen, Ricles, Development of direct integration algorithms ... and inverse compensation, Eng.
         Struct. 31
         (2009); the formula is that of a first-order lead by backward difference.
Valid    Lag of first order. A lag of third order keeps its amplitude error and its curvature.
"""

from __future__ import annotations

from typing import Any

from ..framework.arithmetic import Arithmetic
from ..framework.model import Model, SlotFunction, Values, no_effect
from ..framework.variables import declare, parameter, sampled, state
from .plant import T_F_HAT, led_force
from .plugs import INPUTS, OUTPUTS, SAMPLE_TIME, TERMINALS


class CrInverse(Model):
    """Displacement method: inverse of a lag of first order."""

    name = "cr_inverse"
    description = "First-order inverse of the motion simulator on its command"
    variables = declare(
        parameter(
            "lag",
            0.0355,
            "s",
            "Believed lag of the motion simulator, dead time and hold included",
            minimum=0.0,
        ),
        T_F_HAT,
        SAMPLE_TIME,
        INPUTS,
        OUTPUTS,
        sampled(state("last_f_mea", "N", "Measured force, k-1"), hidden=True),
        sampled(state("last_s_des", "m", "Desired displacement, k-1"), hidden=True),
    )
    terminals = TERMINALS
    sample_time = "sample_time"

    def initial(self, x: Any, u: Any, p: Any, m: Arithmetic) -> Values:
        return {"f_comp": u.f_mea, "s_cmd": u.s_des, "last_f_mea": u.f_mea, "last_s_des": u.s_des}

    def update(self, t: Any, x: Any, u: Any, p: Any, m: Arithmetic, slot: SlotFunction = no_effect) -> Values:
        s_cmd = u.s_des + p.lag / p.sample_time * (u.s_des - x.last_s_des)
        return {
            **{"f_comp": led_force(x, u, p), "s_cmd": s_cmd},
            **{"last_f_mea": u.f_mea, "last_s_des": u.s_des},
        }


MODEL = CrInverse()

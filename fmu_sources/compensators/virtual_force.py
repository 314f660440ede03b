"""
Virtual force: the force of a known spring over the displacement that is missing.

    f_comp = f_mea - k (s_des - s_act),   s_cmd = s_des

Inputs   s_des, s_act, x [m], f_mea [N], v_des [m/s], a_des [m/s2]      used: s_des, s_act, f_mea
Outputs  f_comp [N], s_cmd [m]
States   f_comp, s_cmd   start: f_comp = f_mea - k (s_des - s_act), s_cmd = s_des
Source   References 16 and 17 of the paper; the formula is general knowledge.
Valid    Undamped contact of known stiffness; the lag of the force sensor stays.
"""

from __future__ import annotations

from typing import Any

from ..framework.arithmetic import Arithmetic
from ..framework.model import Model, SlotFunction, Values, no_effect
from ..framework.variables import declare
from .plugs import INPUTS, OUTPUTS, SAMPLE_TIME, STIFFNESS, TERMINALS


class VirtualForce(Model):
    """Force method: a spring on the error of the motion simulator."""

    name = "virtual_force"
    description = "Force of a known spring over the missing displacement"
    variables = declare(STIFFNESS, SAMPLE_TIME, INPUTS, OUTPUTS)
    terminals = TERMINALS
    sample_time = "sample_time"

    def initial(self, x: Any, u: Any, p: Any, m: Arithmetic) -> Values:
        return {"f_comp": u.f_mea - p.stiffness * (u.s_des - u.s_act), "s_cmd": u.s_des}

    def update(self, t: Any, x: Any, u: Any, p: Any, m: Arithmetic, slot: SlotFunction = no_effect) -> Values:
        return {"f_comp": u.f_mea - p.stiffness * (u.s_des - u.s_act), "s_cmd": u.s_des}


MODEL = VirtualForce()

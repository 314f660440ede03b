"""
Virtual damper: the damping that a delayed spring lacks.

    f_mea = -k s_des(t - tau), about -k s_des + k tau v_des
    f_comp = f_mea - k tau v_des,   s_cmd = s_des

Inputs   s_des, s_act, x [m], f_mea [N], v_des [m/s], a_des [m/s2]      used: s_des, f_mea, v_des
Outputs  f_comp [N], s_cmd [m]
States   f_comp, s_cmd   start: f_comp = f_mea - k tau v_des, s_cmd = s_des
Source   Zebenay, Boge, Lampariello, Choukroun, arXiv 1309.3512 and 1409.0562.
Valid    Elastic contact of known stiffness, motion slow against tau. The damping is as wrong as k tau is.
"""

from __future__ import annotations

from typing import Any

from ..framework.arithmetic import Arithmetic
from ..framework.model import Model, SlotFunction, Values, no_effect
from ..framework.variables import declare
from .plugs import INPUTS, LATENCY, OUTPUTS, SAMPLE_TIME, STIFFNESS, TERMINALS


class VirtualDamper(Model):
    """Force method: a damper of k tau."""

    name = "virtual_damper"
    description = "Virtual damper on the spacecraft against the delay of the loop"
    variables = declare(STIFFNESS, LATENCY, SAMPLE_TIME, INPUTS, OUTPUTS)
    terminals = TERMINALS
    sample_time = "sample_time"

    def initial(self, x: Any, u: Any, p: Any, m: Arithmetic) -> Values:
        return {"f_comp": u.f_mea - p.stiffness * p.latency * u.v_des, "s_cmd": u.s_des}

    def update(self, t: Any, x: Any, u: Any, p: Any, m: Arithmetic, slot: SlotFunction = no_effect) -> Values:
        return {"f_comp": u.f_mea - p.stiffness * p.latency * u.v_des, "s_cmd": u.s_des}


MODEL = VirtualDamper()

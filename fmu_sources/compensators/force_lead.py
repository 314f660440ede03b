"""
First-order lead on the measured force against the delay of the whole loop.

    f_comp = f_mea + tau f_mea',   f_mea' = (f_mea(k) - f_mea(k-1))/T,   s_cmd = s_des

Inputs   s_des, s_act, x [m], f_mea [N], v_des [m/s], a_des [m/s2]      used: s_des, f_mea
Outputs  f_comp [N], s_cmd [m]
States   f_comp, s_cmd, last_f_mea [N]   start: f_comp = last_f_mea = f_mea, s_cmd = s_des
Source   References 14 and 15 of the paper; the formula is general knowledge.
Valid    A lag of first order. White noise grows by sqrt(1 + 2 tau/T + 2 (tau/T)^2), 64 for 45 ms at 1 ms.
"""

from __future__ import annotations

from typing import Any

from ..framework.arithmetic import Arithmetic
from ..framework.model import Model, SlotFunction, Values, no_effect
from ..framework.variables import declare, sampled, state
from .plugs import INPUTS, LATENCY, OUTPUTS, SAMPLE_TIME, TERMINALS


class ForceLead(Model):
    """Force method: the force, led by tau."""

    name = "force_lead"
    description = "First-order lead on the measured force against the delay of the loop"
    variables = declare(
        LATENCY,
        SAMPLE_TIME,
        INPUTS,
        OUTPUTS,
        sampled(state("last_f_mea", "N", "Measured force, k-1"), hidden=True),
    )
    terminals = TERMINALS
    sample_time = "sample_time"

    def initial(self, x: Any, u: Any, p: Any, m: Arithmetic) -> Values:
        return {"f_comp": u.f_mea, "s_cmd": u.s_des, "last_f_mea": u.f_mea}

    def update(self, t: Any, x: Any, u: Any, p: Any, m: Arithmetic, slot: SlotFunction = no_effect) -> Values:
        rate = (u.f_mea - x.last_f_mea) / p.sample_time
        return {"f_comp": u.f_mea + p.latency * rate, "s_cmd": u.s_des, "last_f_mea": u.f_mea}


MODEL = ForceLead()

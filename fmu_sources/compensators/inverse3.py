"""
Third-order inverse of the motion simulator on its command, nothing adapted.

    s_cmd  = s_des + d_1 v + d_2 a + d_3 j     Taylor series of 1/M with dead time and hold, see `plant.py`
    f_comp = f_mea + T_f_hat f_mea',   backward difference;   a = f_comp/m_s

Inputs   s_des, s_act, x [m], f_mea [N], v_des [m/s], a_des [m/s2]      used: s_des, f_mea
Outputs  f_comp [N], s_cmd [m]
States   f_comp, s_cmd, last_f_mea, last_s_des, last_a   start: steady in the inputs
Source   Carrion, Spencer, Model-based strategies for real-time hybrid testing, NSEL-006 (2007): the
         inverse as a
         feed-forward of derivatives.
Valid    As far as the believed plant is the plant: the loop has 1 to 2 ms of budget.
"""

from __future__ import annotations

from typing import Any

from ..framework.arithmetic import Arithmetic
from ..framework.model import Model, SlotFunction, Values, no_effect
from ..framework.variables import declare
from .plant import LEAD, acceleration, command, inverse, lead_memory, lead_start, led_force, motion
from .plugs import TERMINALS


class Inverse3(Model):
    """Displacement method: inverse of the believed plant."""

    name = "inverse3"
    description = "Third-order inverse of the motion simulator on its command"
    variables = declare(
        LEAD,
    )
    terminals = TERMINALS
    sample_time = "sample_time"

    def initial(self, x: Any, u: Any, p: Any, m: Arithmetic) -> Values:
        return {"f_comp": u.f_mea, "s_cmd": u.s_des, **lead_start(u, p, m)}

    def update(self, t: Any, x: Any, u: Any, p: Any, m: Arithmetic, slot: SlotFunction = no_effect) -> Values:
        f_comp = led_force(x, u, p)
        now = motion(u.s_des, acceleration(f_comp, u, p, m), x, p)
        return {
            **{"f_comp": f_comp, "s_cmd": command(now, inverse(p))},
            **lead_memory(u, now.a),
        }


MODEL = Inverse3()

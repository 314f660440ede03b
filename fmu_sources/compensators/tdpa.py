"""
Time-domain passivity: a damper that varies takes out what the loop generates, over a third-order inverse.

    E      += T (f_comp v_des - f_l v_act),   E >= 0: energy that the spacecraft has got and the contact
    not given
    f_comp = f_l - beta v,   beta = min(E/(T v^2), largest_damping) where E > 0, else 0
    f_l    = f_mea + T_f_hat f_mea';   s_cmd = s_des + d_1 v + d_2 a + d_3 j, see `plant.py`
    v_des, v_act by backward difference

Inputs   s_des, s_act, x [m], f_mea [N], v_des [m/s], a_des [m/s2]      used: s_des, s_act, f_mea
Outputs  f_comp [N], s_cmd [m]
States   f_comp, s_cmd, energy [J], last values   start: steady in the inputs, energy 0
Source   Ryu, Kwon, Hannaford, Stable teleoperation with time-domain passivity control, IEEE T-RO 20 (2004);
         De Stefano, Balachandran, Secchi, IEEE T-RO 36 (2020) for satellite simulators.
Valid    A guard: a passive loop need not be the one that shall be reproduced, and noise counts as energy.
"""

from __future__ import annotations

from typing import Any

from ..framework.arithmetic import Arithmetic
from ..framework.model import Linear, Model, SlotFunction, Values, no_effect
from ..framework.variables import declare, parameter, sampled, state
from .plant import LEAD, acceleration, command, inverse, lead_memory, lead_start, led_force, motion
from .plugs import TERMINALS

LEAST_SPEED = 1e-9
"""Speed [m/s] below which no damper acts."""


class Tdpa(Model):
    """Force and displacement method: energy observer and damper over an inverse."""

    name = "tdpa"
    description = "Time-domain passivity control over a third-order inverse"
    variables = declare(
        parameter("largest_damping", 2000.0, "N s/m", "Largest damping of the controller", minimum=0.0),
        LEAD,
        sampled(state("energy", "J", "Energy that the loop has generated"), hidden=True),
        sampled(state("last_s_act", "m", "Actual displacement, k-1"), hidden=True),
    )
    terminals = TERMINALS
    linear = (Linear("largest_damping", 0.0, "the damper acts only where energy was generated"),)
    sample_time = "sample_time"

    def initial(self, x: Any, u: Any, p: Any, m: Arithmetic) -> Values:
        start = {"f_comp": u.f_mea, "s_cmd": u.s_des, "energy": 0.0, "last_s_act": u.s_act}
        return start | lead_start(u, p, m)

    def update(self, t: Any, x: Any, u: Any, p: Any, m: Arithmetic, slot: SlotFunction = no_effect) -> Values:
        T = p.sample_time
        f_l = led_force(x, u, p)
        v_des = (u.s_des - x.last_s_des) / T
        v_act = (u.s_act - x.last_s_act) / T
        generated = x.energy + T * (f_l * v_des - f_l * v_act)
        speed = m.where(m.fabs(v_des) > LEAST_SPEED, v_des, LEAST_SPEED)
        needed = m.where(generated > 0.0, generated, 0.0) / (T * speed * speed)
        beta = m.where(needed < p.largest_damping, needed, p.largest_damping)
        f_comp = f_l - beta * v_des
        now = motion(u.s_des, acceleration(f_comp, u, p, m), x, p)
        left = generated - T * beta * v_des * v_des
        return {
            **{"f_comp": f_comp, "s_cmd": command(now, inverse(p))},
            **{"energy": m.where(left > 0.0, left, 0.0), "last_s_act": u.s_act},
            **lead_memory(u, now.a),
        }


MODEL = Tdpa()

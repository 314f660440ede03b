"""
Force of the missing displacement by a stiffness and a damping that are identified on-line, over an inverse.

    f_l    = f_mea + T_f_hat f_mea'
    f_l    = -k s - c s',   s = s_act - x:   (k, c) by recursive least squares with a memory, both
    sides through four poles
    f_comp = f_l - k (s_des - s_act) - c (s_des' - s_act'),   backward differences
    s_cmd  = s_des + d_1 v + d_2 a + d_3 j where `inverse` is on, else s_des; see `plant.py`

Inputs   s_des, s_act, x [m], f_mea [N], v_des [m/s], a_des [m/s2]      used: s_des, s_act, x, f_mea
Outputs  f_comp [N], s_cmd [m]
States   f_comp, s_cmd, the filters (steady in the inputs), normal equations, last values
Source   After Qi, Li, Zhao and others, J. Mech. Des. 145:073302 (2023) and J. Aerosp. Eng. (2024): force
         delay by lead, motion delay by an identified contact.
Deviation  Written from the abstracts: the identifier is a least-squares one of the project's own.
Valid    Contact that a spring and a damper describe near the loop frequency.
"""

from __future__ import annotations

from typing import Any

from ..framework.arithmetic import Arithmetic
from ..framework.model import Linear, Model, SlotFunction, Values, no_effect
from ..framework.variables import declare, parameter, sampled, state, switch, vector
from .plant import (
    LEAD,
    acceleration,
    command,
    four_poles,
    inverse,
    lead_memory,
    lead_start,
    led_force,
    motion,
)
from .plugs import TERMINALS

NOTHING_LEARNED = 1e12
"""Memory [s] that no run fills."""
PRIOR = 1e-9
"""Weight of the believed contact: a mean square of s [m2]."""


class Qi(Model):
    """Force method over an inverse: identified spring and damper."""

    name = "qi"
    description = "Force of the missing displacement by identified stiffness and damping"
    variables = declare(
        parameter("stiffness", 30_255.0, "N/m", "Believed stiffness of the contact k", minimum=0.0),
        parameter("damping", 70.0, "N s/m", "Believed damping of the contact c", minimum=0.0),
        parameter("memory", 0.5, "s", "Memory of the least squares", above=0.0),
        parameter("filter_frequency", 10.0, "Hz", "Corner of the four poles", above=0.0),
        parameter("time_scale", 0.1, "s", "Time that makes s' comparable with s in the prior", above=0.0),
        switch("inverse", True, "Third-order inverse on the command"),
        LEAD,
        sampled(state("last_s_act", "m", "Actual displacement, k-1"), hidden=True),
        vector(sampled(state("force", "N", "f_l after the filter"), hidden=True), 4),
        vector(sampled(state("elongation", "m", "s_act - x after the filter"), hidden=True), 4),
        vector(sampled(state("normal", "m2", "Normal matrix, upper triangle"), hidden=True), 3),
        vector(sampled(state("right", "N m", "Right side of the normal equations"), hidden=True), 2),
    )
    terminals = TERMINALS
    linear = (
        Linear("memory", NOTHING_LEARNED, "identification is not linear: the contact stays as believed"),
    )
    sample_time = "sample_time"

    def initial(self, x: Any, u: Any, p: Any, m: Arithmetic) -> Values:
        return {
            **{"f_comp": u.f_mea, "s_cmd": u.s_des, **lead_start(u, p, m), "last_s_act": u.s_act},
            **{"force": (u.f_mea,) * 4, "elongation": (u.s_act - u.x,) * 4},
            **{"normal": (0.0,) * 3, "right": (0.0,) * 2},
        }

    def update(self, t: Any, x: Any, u: Any, p: Any, m: Arithmetic, slot: SlotFunction = no_effect) -> Values:
        T = p.sample_time
        f_l = led_force(x, u, p)
        share = 1.0 - m.exp(-2.0 * m.pi * p.filter_frequency * T)
        force = four_poles(x.force, f_l, share)
        elongation = four_poles(x.elongation, u.s_act - u.x, share)
        s = elongation[3]
        rate = p.time_scale * (s - x.elongation[3]) / T
        left = -force[3] - p.stiffness * s - p.damping / p.time_scale * rate
        w = T / p.memory
        n00, n01, n11 = (
            old + w * (new - old) for old, new in zip(x.normal, (s * s, s * rate, rate * rate), strict=True)
        )
        r0, r1 = (old + w * (part * left - old) for old, part in zip(x.right, (s, rate), strict=True))
        determinant = (n00 + PRIOR) * (n11 + PRIOR) - n01 * n01
        k = p.stiffness + ((n11 + PRIOR) * r0 - n01 * r1) / determinant
        c = p.damping + ((n00 + PRIOR) * r1 - n01 * r0) / determinant * p.time_scale
        missing = u.s_des - u.s_act
        f_comp = f_l - k * missing - c * (missing - (x.last_s_des - x.last_s_act)) / T
        now = motion(u.s_des, acceleration(f_comp, u, p, m), x, p)
        return {
            **{"f_comp": f_comp, "s_cmd": m.where(p.inverse, command(now, inverse(p)), u.s_des)},
            **lead_memory(u, now.a),
            "last_s_act": u.s_act,
            **{"force": force, "elongation": elongation, "normal": (n00, n01, n11), "right": (r0, r1)},
        }


MODEL = Qi()

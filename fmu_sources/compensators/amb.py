"""
Adaptive model-based compensation: the inverse, its coefficients by a gradient.

    s_cmd   = theta_0 s + theta_1 v + theta_2 a + theta_3 j,   theta at the start: 1, d_1, d_2, d_3 of
    `plant.py`
    phi     = s_act and its derivatives, L s_cmd = L theta phi + e, L: four poles at filter_frequency
    theta_i += T rate d_i^2 phi_i e/(level^2 + sum d_j^2 phi_j^2),   d_0 = 1
    f_comp  = f_mea + T_f_hat f_mea';   a = f_comp/m_s

Inputs   s_des, s_act, x [m], f_mea [N], v_des [m/s], a_des [m/s2]      used: s_des, s_act, f_mea
Outputs  f_comp [N], s_cmd [m]
States   f_comp, s_cmd, the filters (steady in s_act), theta, last values
Source   Chen, Chang, Spencer, Tsai, Adaptive model-based tracking control for real-time hybrid simulation,
         Bull. Earthquake Eng. 13 (2015); Fermandois-Cornejo, RobustAMBCvRTHS.
Deviation  The gains are relative rates, so that they do not depend on amplitude; four equal poles instead
         of a Butterworth filter.
Valid    Plants near the believed one: the rates are those of drift, not of a wrong start.
"""

from __future__ import annotations

from typing import Any

from ..framework.arithmetic import Arithmetic
from ..framework.model import Linear, Model, SlotFunction, Values, no_effect
from ..framework.variables import declare, parameter, sampled, state, vector
from .plant import LEAD, acceleration, four_poles, inverse, lead_memory, lead_start, led_force, motion
from .plugs import TERMINALS


class Amb(Model):
    """Displacement method: inverse with coefficients that follow a gradient."""

    name = "amb"
    description = "Adaptive model-based inverse of the motion simulator"
    variables = declare(
        parameter("rate", 1.0, "1/s", "Rate of the adaptation", minimum=0.0),
        parameter("filter_frequency", 20.0, "Hz", "Corner of the four poles", above=0.0),
        parameter("level", 1e-6, "m", "Amplitude below which nothing is learned, above the noise", above=0.0),
        LEAD,
        vector(sampled(state("commanded", "m", "s_cmd after the filter"), hidden=True), 4),
        vector(sampled(state("reached", "m", "s_act after the filter"), hidden=True), 4),
        vector(sampled(state("past", "m", "Filtered s_act of earlier periods"), hidden=True), 3),
        vector(sampled(state("theta", "1", "Change of theta_i in terms of d_i"), hidden=True), 4),
    )
    terminals = TERMINALS
    linear = (Linear("rate", 0.0, "adaptation is not linear: the inverse stays as believed"),)
    sample_time = "sample_time"

    def initial(self, x: Any, u: Any, p: Any, m: Arithmetic) -> Values:
        return {
            **{"f_comp": u.f_mea, "s_cmd": u.s_des, **lead_start(u, p, m), "theta": (0.0,) * 4},
            **{"commanded": (u.s_act,) * 4, "reached": (u.s_act,) * 4, "past": (u.s_act,) * 3},
        }

    def update(self, t: Any, x: Any, u: Any, p: Any, m: Arithmetic, slot: SlotFunction = no_effect) -> Values:
        T = p.sample_time
        f_comp = led_force(x, u, p)
        now = motion(u.s_des, acceleration(f_comp, u, p, m), x, p)
        d = inverse(p)
        wanted = (now.s, d.d1 * now.v, d.d2 * now.a, d.d3 * now.j)
        s_cmd = sum((1.0 + theta) * part for theta, part in zip(x.theta, wanted, strict=True))
        share = 1.0 - m.exp(-2.0 * m.pi * p.filter_frequency * T)
        commanded = four_poles(x.commanded, s_cmd, share)
        reached = four_poles(x.reached, u.s_act, share)
        s = reached[3]
        s1, s2, s3 = x.past
        once = s - s1
        twice = s - 2.0 * s1 + s2
        thrice = s - 3.0 * (s1 - s2) - s3
        phi = (
            s,
            d.d1 * (once + twice / 2.0 + thrice / 3.0) / T,
            d.d2 * (twice + thrice) / (T * T),
            d.d3 * thrice / (T * T * T),
        )
        left = commanded[3] - sum((1.0 + theta) * part for theta, part in zip(x.theta, phi, strict=True))
        size = p.level * p.level + sum(part * part for part in phi)
        theta = tuple(old + T * p.rate * part * left / size for old, part in zip(x.theta, phi, strict=True))
        return {
            **{"f_comp": f_comp, "s_cmd": s_cmd, "theta": theta},
            **lead_memory(u, now.a),
            **{"commanded": commanded, "reached": reached, "past": (s, s1, s2)},
        }


MODEL = Amb()

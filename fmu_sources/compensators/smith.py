"""
Smith predictor: the force of the delayed model is replaced by that of the undelayed one, over an inverse.

    s_model = M(s) s_cmd,   M the believed motion simulator, dead time rounded to periods, command held
    y_d, y_m = G(q) (s_des - x), G(q) (s_model - x),   G the believed contact, bilinear, steady at the start
    f_comp  = f_l + y_m - y_d,   f_l = f_mea + T_f_hat f_mea'
    s_cmd   = s_des + d_1 v + d_2 a + d_3 j where `inverse` is on, else s_des; see `plant.py`

Inputs   s_des, s_act, x [m], f_mea [N], v_des [m/s], a_des [m/s2]      used: s_des, x, f_mea; s_act at the
         start
Outputs  f_comp [N], s_cmd [m]
States   f_comp, s_cmd, the models, last values   start: steady in the inputs
Source   Smith, Closer control of loops with dead time, Chem. Eng. Prog. 53 (1957). The contact: paper,
         Eqs. 11, 15.
Valid    As far as both models are right: s_act is not used, an error of the plant's lag acts on the loop
         as it is.
"""

from __future__ import annotations

from typing import Any

from ..compensator.difference import process_parameters
from ..docking_contact.equations import PARAMETERS as CONTACT_PARAMETERS
from ..framework.arithmetic import Arithmetic
from ..framework.model import Model, SlotFunction, Values, no_effect
from ..framework.variables import declare, sampled, state, switch, vector
from .plant import LEAD, acceleration, command, inverse, lead_memory, lead_start, led_force, motion
from .plugs import TERMINALS

BILINEAR = 0.5
LONGEST = 20
"""Longest dead time in periods."""


class Smith(Model):
    """Force method over an inverse: the force of a model without delay."""

    name = "smith"
    description = "Smith predictor with models of motion simulator and contact"
    variables = declare(
        [v for v in CONTACT_PARAMETERS if not v.name.startswith("k_p_")],
        switch("inverse", True, "Third-order inverse on the command"),
        LEAD,
        sampled(state("s_model", "m", "Displacement of the believed plant"), hidden=True),
        sampled(state("v_model", "m/s", "Its velocity"), hidden=True),
        sampled(state("a_model", "m/s2", "Its acceleration"), hidden=True),
        vector(sampled(state("line", "m", "Commands of earlier periods"), hidden=True), LONGEST + 1),
        vector(sampled(state("desired", "m", "s_des - x of earlier periods"), hidden=True), 2),
        vector(sampled(state("modelled", "m", "s_model - x of earlier periods"), hidden=True), 2),
        vector(sampled(state("y_d", "N", "Model force of s_des of earlier periods"), hidden=True), 2),
        vector(sampled(state("y_m", "N", "Model force of s_model of earlier periods"), hidden=True), 2),
    )
    terminals = TERMINALS
    sample_time = "sample_time"

    def initial(self, x: Any, u: Any, p: Any, m: Arithmetic) -> Values:
        k = p.k_m * p.k_p / (p.k_m + p.k_p)
        desired = u.s_des - u.x
        modelled = u.s_act - u.x
        return {
            **{"f_comp": u.f_mea + k * (modelled - desired), "s_cmd": u.s_des, **lead_start(u, p, m)},
            **{"s_model": u.s_act, "v_model": 0.0, "a_model": 0.0, "line": (u.s_act,) * (LONGEST + 1)},
            **{"desired": (desired,) * 2, "modelled": (modelled,) * 2},
            **{"y_d": (k * desired,) * 2, "y_m": (k * modelled,) * 2},
        }

    def update(self, t: Any, x: Any, u: Any, p: Any, m: Arithmetic, slot: SlotFunction = no_effect) -> Values:
        Y = process_parameters(p, BILINEAR)
        desired = u.s_des - u.x
        modelled = x.s_model - u.x
        y_d = _force(Y, x.y_d, (desired, *x.desired))
        y_m = _force(Y, x.y_m, (modelled, *x.modelled))
        f_comp = led_force(x, u, p) + y_m - y_d
        now = motion(u.s_des, acceleration(f_comp, u, p, m), x, p)
        s_cmd = m.where(p.inverse, command(now, inverse(p)), u.s_des)
        line = (s_cmd, *x.line[:-1])
        acting = m.pick(line, m.floor(p.dead_time / p.sample_time + 0.5))
        s, v, a = _plant((x.s_model, x.v_model, x.a_model), acting, p)
        return {
            **{"f_comp": f_comp, "s_cmd": s_cmd},
            **lead_memory(u, now.a),
            **{"s_model": s, "v_model": v, "a_model": a, "line": line},
            **{"desired": (desired, x.desired[0]), "modelled": (modelled, x.modelled[0])},
            **{"y_d": (y_d, x.y_d[0]), "y_m": (y_m, x.y_m[0])},
        }


def _force(Y: Any, y: Any, s: Any) -> Any:
    a, b, c, d, e = Y
    return a * y[0] + b * y[1] + c * s[0] + d * s[1] + e * s[2]


def _plant(start: tuple[Any, Any, Any], s_cmd: Any, p: Any) -> tuple[Any, ...]:
    """Step the believed plant by one period: the exponential series to fourth order (Runge-Kutta)."""
    T = p.sample_time
    state = start
    for divisor in (4.0, 3.0, 2.0, 1.0):
        s, v, a = state
        jerk = p.w_v * p.w_v * (p.K_p * (s_cmd - s) - v) - 2.0 * p.z * p.w_v * a
        state = tuple(x + T / divisor * rate for x, rate in zip(start, (v, a, jerk), strict=True))
    return state


MODEL = Smith()

"""
Adaptive time series: the command from displacement, velocity and acceleration, coefficients by least squares.

    s_cmd = a_0 s + a_1 v + a_2 a
    (a_0, a_1, a_2): least squares of L s_cmd = L (a_0 s_act + a_1 s_act' + a_2 s_act''), L four poles at
    filter_frequency, in a memory of `memory` seconds, with the believed plant as the start:
    sum w phi phi' + prior,   phi in terms of 1, d_1, d_2;   changes of a_i within +-bound of d_i
    f_comp = f_mea + T_f_hat f_mea';   a = f_comp/m_s

Inputs   s_des, s_act, x [m], f_mea [N], v_des [m/s], a_des [m/s2]      used: s_des, s_act, f_mea
Outputs  f_comp [N], s_cmd [m]
States   f_comp, s_cmd, the filters (steady in s_act), normal equations, last values
Source   Chae, Kazemibidokhti, Ricles, Adaptive time series compensator for delay compensation of
         servo-hydraulic actuator systems for real-time hybrid simulation,
         Earthquake Eng. Struct. Dyn. 42 (2013).
Deviation  A memory that fades instead of a moving window; the prior keeps the equations regular at one
         frequency.
Valid    Second order: what a plant of third order does beyond it stays.
"""

from __future__ import annotations

from typing import Any

from ..framework.arithmetic import Arithmetic
from ..framework.model import Linear, Model, SlotFunction, Values, no_effect
from ..framework.variables import declare, parameter, sampled, state, vector
from .plant import LEAD, acceleration, four_poles, inverse, lead_memory, lead_start, led_force, motion
from .plugs import TERMINALS

PRIOR = 1e-10
"""Weight of the believed plant: a mean square of s_act [m2]."""


class Ats(Model):
    """Displacement method: inverse of second order by least squares."""

    name = "ats"
    description = "Adaptive time series compensator"
    variables = declare(
        parameter("memory", 1.0, "s", "Memory of the least squares", above=0.0),
        parameter(
            "bound", 0.3, "1", "Largest change of a coefficient in terms of the believed one", minimum=0.0
        ),
        parameter("filter_frequency", 20.0, "Hz", "Corner of the four poles", above=0.0),
        LEAD,
        vector(sampled(state("commanded", "m", "s_cmd after the filter"), hidden=True), 4),
        vector(sampled(state("reached", "m", "s_act after the filter"), hidden=True), 4),
        vector(sampled(state("past", "m", "Filtered s_act of earlier periods"), hidden=True), 2),
        vector(sampled(state("normal", "m2", "Normal matrix, upper triangle by rows"), hidden=True), 6),
        vector(sampled(state("right", "m2", "Right side of the normal equations"), hidden=True), 3),
    )
    terminals = TERMINALS
    linear = (Linear("bound", 0.0, "adaptation is not linear: the inverse stays as believed"),)
    sample_time = "sample_time"

    def initial(self, x: Any, u: Any, p: Any, m: Arithmetic) -> Values:
        return {
            **{"f_comp": u.f_mea, "s_cmd": u.s_des, **lead_start(u, p, m)},
            **{"commanded": (u.s_act,) * 4, "reached": (u.s_act,) * 4, "past": (u.s_act,) * 2},
            **{"normal": (0.0,) * 6, "right": (0.0,) * 3},
        }

    def update(self, t: Any, x: Any, u: Any, p: Any, m: Arithmetic, slot: SlotFunction = no_effect) -> Values:
        T = p.sample_time
        f_comp = led_force(x, u, p)
        now = motion(u.s_des, acceleration(f_comp, u, p, m), x, p)
        d = inverse(p)
        changes = _solved(x.normal, x.right)
        bounded = [m.where(c > p.bound, p.bound, m.where(c < -p.bound, -p.bound, c)) for c in changes]
        wanted = (now.s, d.d1 * now.v, d.d2 * now.a)
        s_cmd = sum((1.0 + c) * part for c, part in zip(bounded, wanted, strict=True))
        share = 1.0 - m.exp(-2.0 * m.pi * p.filter_frequency * T)
        commanded = four_poles(x.commanded, s_cmd, share)
        reached = four_poles(x.reached, u.s_act, share)
        s = reached[3]
        s1, s2 = x.past
        once = s - s1
        twice = s - 2.0 * s1 + s2
        phi = (s, d.d1 * (once + twice / 2.0) / T, d.d2 * twice / (T * T))
        left = commanded[3] - sum(phi)
        products = (
            *(phi[0] * part for part in phi),
            *(phi[1] * part for part in phi[1:]),
            phi[2] * phi[2],
        )
        w = T / p.memory
        return {
            **{"f_comp": f_comp, "s_cmd": s_cmd},
            **lead_memory(u, now.a),
            **{"commanded": commanded, "reached": reached, "past": (s, s1)},
            "normal": tuple(old + w * (new - old) for old, new in zip(x.normal, products, strict=True)),
            "right": tuple(old + w * (part * left - old) for old, part in zip(x.right, phi, strict=True)),
        }


def _solved(normal: Any, right: Any) -> tuple[Any, Any, Any]:
    """Solve the normal equations with the prior by Cholesky's way: no pivot is below PRIOR."""
    n00, n01, n02, n11, n12, n22 = normal
    d0 = n00 + PRIOR
    l10 = n01 / d0
    l20 = n02 / d0
    d1 = n11 + PRIOR - l10 * n01
    c12 = n12 - l10 * n02
    l21 = c12 / d1
    d2 = n22 + PRIOR - l20 * n02 - l21 * c12
    y0 = right[0]
    y1 = right[1] - l10 * y0
    y2 = right[2] - l20 * y0 - l21 * y1
    c2 = y2 / d2
    c1 = y1 / d1 - l21 * c2
    return y0 / d0 - l10 * c1 - l20 * c2, c1, c2


MODEL = Ats()

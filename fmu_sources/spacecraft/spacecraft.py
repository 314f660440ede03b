"""
Spacecraft dynamics in one degree of freedom, a mass under the compensated contact force.

    m_s s_des'' = f                                                                              (1)
    D(s)        = 1/(m_s s^2)                                                                    (2)

One sampling period T, with the force that is set before it:

    semi_implicit    v(k+1) = v(k) + T f/m_s     s(k+1) = s(k) + T v(k+1)
    zero_order_hold  v(k+1) = v(k) + T f/m_s     s(k+1) = s(k) + T v(k) + T^2 f/(2 m_s)
    explicit_euler   v(k+1) = v(k) + T f/m_s     s(k+1) = s(k) + T v(k)
    leapfrog         as semi_implicit, but for the first impulse, which is halved: v(1) = v(0) + T f/(2 m_s)

Inputs   f [N]
Outputs  s_des [m], v_des [m/s]      the states
States   s_des [m], v_des [m/s]      start: 0, settable; has_started [1], start: 0
Source   Paper, Sec. III-A, Eqs. 1-2; integrators: Hairer, Lubich, Wanner, Geometric Numerical Integration,
         Sec. I.1.
Deviation  Eq. 1 names the measured force; with compensation it is the compensated one.
Valid    One axis, no gravity, no torque. In a loop the first three forms differ by force delays of 0, T/2, T.
         semi_implicit takes v(0) for the velocity half a period before the start and adds the motion of an
         impulse T f(0)/2; leapfrog starts that velocity right, and its v_des is half a period before s_des.
"""

from __future__ import annotations

from enum import IntEnum
from typing import Any

from ..framework.arithmetic import Arithmetic
from ..framework.model import Delay, Model, SlotFunction, Values, no_effect
from ..framework.variables import choice, declare, fixed, input_, parameter, sampled, state


class Integrator(IntEnum):
    """How displacement and velocity follow from the force over one sampling period."""

    semi_implicit = 1
    zero_order_hold = 2
    explicit_euler = 3
    leapfrog = 4


class Spacecraft(Model):
    """Eqs. 1-2 at the sampling instants."""

    name = "spacecraft"
    description = "Mass of the spacecraft under the compensated contact force"
    variables = declare(
        parameter("m_s", 820.0, "kg", "Mass of the spacecraft", above=0.0),
        fixed(parameter("sample_time", 1e-3, "s", "Sampling period", above=0.0)),
        choice("integrator", Integrator.semi_implicit, "Integration of Eq. 1 over one sampling period"),
        input_("f", "N", "Force on the spacecraft"),
        sampled(state("s_des", "m", "Desired displacement", output=True)),
        sampled(state("v_des", "m/s", "Desired velocity", output=True)),
        sampled(state("has_started", "1", "1 after the first sampling period"), hidden=True),
    )
    delays = (
        Delay(
            input="f",
            kind="integrator",
            by="integrator",
            steps={"semi_implicit": -1.0, "zero_order_hold": -0.5, "explicit_euler": 0.0, "leapfrog": -1.0},
            reason="the force acts from the start of the step, spread by the integrator",
        ),
    )
    sample_time = "sample_time"

    def update(self, t: Any, x: Any, u: Any, p: Any, m: Arithmetic, slot: SlotFunction = no_effect) -> Values:
        T = p.sample_time
        is_halved = m.both(p.integrator == Integrator.leapfrog, x.has_started == 0.0)
        dv = m.where(is_halved, 0.5, 1.0) * (T * u.f / p.m_s)
        v_des = x.v_des + dv
        v_mean = m.pick((v_des, x.v_des + 0.5 * dv, x.v_des, v_des), p.integrator - 1)
        return {"s_des": x.s_des + T * v_mean, "v_des": v_des, "has_started": 1.0}


MODEL = Spacecraft()

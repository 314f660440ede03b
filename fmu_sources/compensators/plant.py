"""
What methods believe of the motion simulator and the force sensor: parameters, the inverse, the model.

    1/M(s)  = (1 + b_1 s + b_2 s^2 + b_3 s^3) exp(tau s),   tau = dead_time + T/2 (hold of the command)
            = 1 + d_1 s + d_2 s^2 + d_3 s^3 + ...            b_1 = 1/K_p, b_2 = 2 z/(w_v K_p), b_3 =
            1/(w_v^2 K_p)
    s_cmd   = s + d_1 v + d_2 a + d_3 j
    v = (s(k) - s(k-1))/T + T a/2,   j = (a(k) - a(k-1))/T,   a = f_comp/m_s, or a_des where that is said

Source   The plant: `motion_simulator_linear`. The inverse is its Taylor series.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

from ..framework.arithmetic import Arithmetic
from ..framework.variables import declare, parameter, sampled, state, switch
from .plugs import INPUTS, OUTPUTS, SAMPLE_TIME

T_F_HAT = parameter("T_f_hat", 0.01, "s", "Believed time constant of the force sensor", minimum=0.0)
M_S = parameter("m_s", 820.0, "kg", "Mass of the spacecraft as in its model", above=0.0)
PLANT = declare(
    parameter("K_p", 30.0, "1/s", "Believed gain of the position loop of the motion simulator", above=0.0),
    parameter("w_v", 40.0 * math.pi, "rad/s", "Believed natural frequency of its velocity loop", above=0.0),
    parameter("z", 0.8, "1", "Believed damping ratio of its velocity loop", above=0.0),
    parameter("dead_time", 0.002, "s", "Believed dead time of its command", minimum=0.0, maximum=0.1),
)
USES_A_DES = switch(
    "uses_a_des", False, "True where a_des is given: other forces than f_comp act on the simulated mass"
)
LEAD_MEMORY = declare(
    sampled(state("last_f_mea", "N", "Measured force, k-1"), hidden=True),
    sampled(state("last_s_des", "m", "Desired displacement, k-1"), hidden=True),
    sampled(state("last_a", "m/s2", "Acceleration of the spacecraft, k-1"), hidden=True),
)
"""States of `led_force` and `motion`."""
LEAD = declare(T_F_HAT, M_S, PLANT, USES_A_DES, SAMPLE_TIME, INPUTS, OUTPUTS, LEAD_MEMORY)
"""What every method declares that leads the force and inverts the plant."""


class Inverse(NamedTuple):
    """Taylor coefficients of 1/M [s, s^2, s^3]."""

    d1: Any
    d2: Any
    d3: Any


class Motion(NamedTuple):
    """Displacement [m] of the spacecraft and its derivatives [m/s, m/s2, m/s3]."""

    s: Any
    v: Any
    a: Any
    j: Any


def inverse(p: Any, advance: Any = 0.0) -> Inverse:
    """Return the coefficients of exp(advance s)/M, dead time and hold of the command included."""
    tau = p.dead_time + 0.5 * p.sample_time + advance
    b1 = 1.0 / p.K_p
    b2 = 2.0 * p.z / (p.w_v * p.K_p)
    b3 = 1.0 / (p.w_v * p.w_v * p.K_p)
    return Inverse(
        b1 + tau,
        b2 + tau * b1 + tau * tau / 2.0,
        b3 + tau * b2 + tau * tau / 2.0 * b1 + tau * tau * tau / 6.0,
    )


def led_force(x: Any, u: Any, p: Any) -> Any:
    """Return the force [N] before the lag of the sensor, by backward difference."""
    return u.f_mea + p.T_f_hat * (u.f_mea - x.last_f_mea) / p.sample_time


def motion(s_des: Any, a: Any, x: Any, p: Any) -> Motion:
    """Return the motion of the spacecraft from its displacement [m] and its acceleration [m/s2]."""
    T = p.sample_time
    return Motion(s_des, (s_des - x.last_s_des) / T + 0.5 * T * a, a, (a - x.last_a) / T)


def acceleration(f_comp: Any, u: Any, p: Any, m: Arithmetic) -> Any:
    """Return the acceleration of the simulated mass [m/s2]."""
    return m.where(p.uses_a_des, u.a_des, f_comp / p.m_s)


def command(now: Motion, d: Inverse) -> Any:
    """Return the command [m] that the believed plant turns into the motion."""
    return now.s + d.d1 * now.v + d.d2 * now.a + d.d3 * now.j


def lead_start(u: Any, p: Any, m: Arithmetic) -> dict[str, Any]:
    """Return the start of `LEAD_MEMORY`."""
    return lead_memory(u, acceleration(u.f_mea, u, p, m))


def lead_memory(u: Any, a: Any) -> dict[str, Any]:
    """Return `LEAD_MEMORY` after a period with the acceleration a [m/s2]."""
    return {"last_f_mea": u.f_mea, "last_s_des": u.s_des, "last_a": a}


def four_poles(stages: Any, value: Any, share: Any) -> tuple[Any, ...]:
    """Step four equal low-passes in a row, each by a share of what it lacks."""
    found = []
    for stage in stages:
        value = stage + share * (value - stage)
        found.append(value)
    return tuple(found)

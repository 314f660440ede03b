"""
The drive of one leg: cascade of P and PI controllers, electrics and friction of the motor (Fig. 8).

    om     = K2 der(l),   K2 = 2 pi / lead
    e_v    = K2 Kpp (l_ref - l) - om                 position controller, P
    i_ref  = limited(Kvp e_v + Kvi z, i_max)         speed controller, PI
    der(z) = e_v                                     0 while i_ref is limited and e_v drives it further
    V      = limited(Kc (i_ref - beta i), V_max)     current controller, P
    L der(i) = V - R_a i - Ke om
    f      = K2 (KT i - B om)                        force along the leg, without the rotor's inertia

The rotor's share of the leg's force, -J K2^2 l'', stands in the equation of motion.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

from ..framework.arithmetic import Arithmetic


class Drive(NamedTuple):
    """Force along the leg [N], changes of the states, and what the controllers ask for: i_pi [A], V_p [V]."""

    force: Any
    der_current: Any
    der_integral: Any
    i_pi: Any
    V_p: Any


def screw(p: Any, m: Arithmetic) -> Any:
    """K2: angle of the motor per length of the leg [rad/m]."""
    return 2.0 * m.pi / p.lead


def limited(value: Any, bound: Any, m: Arithmetic) -> Any:
    """Keep a value within -bound and +bound."""
    return m.where(value > bound, bound, m.where(value < -bound, -bound, value))


def drive(
    error: Any,
    der_l: Any,
    i: Any,
    z: Any,
    resistance: Callable[[Any, Any], Any],
    p: Any,
    m: Arithmetic,
) -> Drive:
    """
    Forces and changes of one drive.

    Args:
        error: l_ref - l [m].
        der_l: Rate of the leg's length [m/s].
        i: Motor current [A].
        z: Integral of the speed error [rad].
        resistance: `resistance(viscous force, motor force)` [N] gives the force that resists the motion.
        p: Parameters.
        m: Arithmetic.
    """
    K2 = screw(p, m)
    om = K2 * der_l
    e_v = K2 * p.Kpp * error - om
    i_pi = p.Kvp * e_v + p.Kvi * z
    current_limited = m.fabs(i_pi) > p.i_max
    V_p = p.Kc * (limited(i_pi, p.i_max, m) - p.beta * i)
    V = limited(V_p, p.V_max, m)
    motor = K2 * p.KT * i
    return Drive(
        force=motor - resistance(K2 * p.B * om, motor),
        der_current=(V - p.R_a * i - p.Ke * om) / p.L,
        der_integral=m.where(m.both(current_limited, e_v * i_pi > 0.0), 0.0, e_v),
        i_pi=i_pi,
        V_p=V_p,
    )

"""
Real docking in space, the ideal that every hardware-in-the-loop run is held against.

    m_s s''   = f                                                                                (1)
    x_d       = x_e + x,   der(x) = v                                                            (5, 6)
    m_e x_e'' = -k_m x_e - c_m x_e' + k_p(t) (s - x_d) + c_p (s' - x_d')                         (7)
    f         = -k_m x_e - c_m x_e'                                                              (9)

Inputs   v [m/s] (drag velocity)
Outputs  s [m], v_s [m/s], x [m], f [N]   direct feedthrough: none
States   s [m], v_s [m/s], x [m]          start: 0, settable
         x_e [m], der_x_e [m/s]           start: at rest in equilibrium with s and x
Source   Paper, Sec. II, Fig. 4, Eqs. 1 and 5-9.
Deviation  Eq. 3 neglects part of the inertia of the end-effector; here the force at the frame side (Eq. 9)
         moves the spacecraft, as in the paper's loop: w^4 - (K/m_e) w^2 + k_m k_p/(m_s m_e) = 0 undamped.
Valid    As `docking_contact`.
"""

from __future__ import annotations

from typing import Any

from ..docking_contact.equations import (
    LINEAR,
    PARAMETERS,
    SLOTS,
    acceleration,
    contact_force,
    equilibrium,
    rope_force,
    rope_stiffness,
)
from ..framework.arithmetic import Arithmetic
from ..framework.model import Delay, Model, SlotFunction, Values, no_effect
from ..framework.variables import declare, input_, output, parameter, state


class RealDocking(Model):
    """Spacecraft and contact in one, without motion simulator, sensor and sampling."""

    name = "real_docking"
    description = "Real docking: spacecraft, rope, end-effector and manipulator without any simulator"
    variables = declare(
        parameter("m_s", 820.0, "kg", "Mass of the spacecraft", above=0.0),
        PARAMETERS,
        input_("v", "m/s", "Velocity of the drag mechanism relative to the end-effector"),
        state("s", "m", "Displacement of the spacecraft", output=True),
        state("v_s", "m/s", "Velocity of the spacecraft", output=True),
        state("x_e", "m", "Displacement of the end-effector"),
        state("der_x_e", "m/s", "Velocity of the end-effector"),
        state("x", "m", "Travel of the drag mechanism relative to the end-effector", output=True),
        output("f", "N", "Contact force on the spacecraft"),
    )
    slots = SLOTS
    linear = LINEAR
    delays = (Delay(input="v", kind="hold", steps=-0.5, reason="the value set before the step is held"),)

    def initial(self, x: Any, u: Any, p: Any, m: Arithmetic) -> Values:
        return {"x_e": equilibrium(x.s, x.x, p), "der_x_e": 0.0}

    def derivatives(
        self, t: Any, x: Any, u: Any, p: Any, m: Arithmetic, slot: SlotFunction = no_effect
    ) -> Values:
        f = contact_force(x, p, slot)
        f_r = rope_force((x.s, x.v_s), u.v, x, rope_stiffness(t, p, m), p, slot)
        return {
            "s": x.v_s,
            "v_s": f / p.m_s,
            "x_e": x.der_x_e,
            "der_x_e": acceleration(f, f_r, x, p, slot),
            "x": u.v,
        }

    def outputs(
        self, t: Any, x: Any, u: Any, p: Any, m: Arithmetic, slot: SlotFunction = no_effect
    ) -> Values:
        return {"f": contact_force(x, p, slot)}


MODEL = RealDocking()

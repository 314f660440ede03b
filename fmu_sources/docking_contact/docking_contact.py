"""
Contact force between drag mechanism and end-effector, one degree of freedom.

    x_d       = x_e + x,   der(x) = v                                                            (5, 6)
    m_e x_e'' = -k_m x_e - c_m x_e' + k_p(t) (s_act - x_d) + c_p (s_act' - x_d')                 (7)
    f_act     = -k_m x_e - c_m x_e'                                                              (9)
    F_act     = -(k_m + c_m s)(k_p + c_p s)/(m_e s^2 + (c_m + c_p) s + k_m + k_p) (S_act - X)    (11)
    k_p(t)    = k_p + k_p_amplitude sin(2 pi k_p_frequency t)                                    (Sec. V-A.3)

Inputs   s_act [m], v_act [m/s], v [m/s] (drag velocity)
Outputs  f_act [N], x [m]                direct feedthrough: none
States   x_e [m], der_x_e [m/s]          start: at rest in equilibrium with s_act and x
         x [m] (drag travel)             start: 0, settable
Source   Paper, Sec. III-C, Eqs. 5-11, and Sec. V-A.3.
Deviation  Eq. 7 prints c_p (s_act - x_d'); s_act' is used, as Eq. 8 requires. Eq. 11 prints m_s for m_e and
         a plus for the minus.
Valid    Bilateral spring for the rope (a rope that slackens needs an effect in `rope_force`), small motion.
"""

from __future__ import annotations

from typing import Any

from ..framework.arithmetic import Arithmetic
from ..framework.model import Delay, InputHold, Model, SlotFunction, Values, no_effect
from ..framework.variables import choice, declare, input_, output, state
from .equations import (
    LINEAR,
    PARAMETERS,
    SLOTS,
    acceleration,
    contact_force,
    equilibrium,
    rope_force,
    rope_stiffness,
)

HOLD_STEPS = {"interpolate": 0.0, "hold_new": -0.5, "hold_old": 0.5}


class DockingContact(Model):
    """Eqs. 5-10 driven by the motion of the motion simulator."""

    name = "docking_contact"
    description = "Contact of drag mechanism, rope and manipulator, force at the frame side"
    variables = declare(
        PARAMETERS,
        choice("input_hold", InputHold.interpolate, "Course of the inputs during a communication step"),
        input_("s_act", "m", "Actual displacement of the motion simulator"),
        input_("v_act", "m/s", "Actual velocity of the motion simulator"),
        input_("v", "m/s", "Velocity of the drag mechanism relative to the end-effector"),
        state("x_e", "m", "Displacement of the end-effector"),
        state("der_x_e", "m/s", "Velocity of the end-effector"),
        state("x", "m", "Travel of the drag mechanism relative to the end-effector", output=True),
        output("f_act", "N", "Actual contact force at the sensor"),
    )
    slots = SLOTS
    linear = LINEAR
    delays = tuple(
        Delay(input=name, kind="hold", by="input_hold", steps=HOLD_STEPS, reason="course within a step")
        for name in ("s_act", "v_act", "v")
    )
    input_hold = "input_hold"

    def initial(self, x: Any, u: Any, p: Any, m: Arithmetic) -> Values:
        return {"x_e": equilibrium(u.s_act, x.x, p), "der_x_e": 0.0}

    def derivatives(
        self, t: Any, x: Any, u: Any, p: Any, m: Arithmetic, slot: SlotFunction = no_effect
    ) -> Values:
        f_m = contact_force(x, p, slot)
        f_r = rope_force((u.s_act, u.v_act), u.v, x, rope_stiffness(t, p, m), p, slot)
        return {"x_e": x.der_x_e, "der_x_e": acceleration(f_m, f_r, x, p, slot), "x": u.v}

    def outputs(
        self, t: Any, x: Any, u: Any, p: Any, m: Arithmetic, slot: SlotFunction = no_effect
    ) -> Values:
        return {"f_act": contact_force(x, p, slot)}


MODEL = DockingContact()

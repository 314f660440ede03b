"""
Position servo that carries a load against gravity.

    J q'' = k (q_ref - q) - F - G sin(q),   k (q_ref - q) in slot `drive`,   F = d q' in slot `friction`

Inputs   q_ref [rad]
Outputs  q [rad], der_q [rad/s] (states)    direct feedthrough: none
States   q, der_q                           start: 0, where the load hangs
Slots    drive: k (q_ref - q);  friction: d q', of q and der_q
Source   Proportional position control of a link under gravity; Siciliano et al., Robotics (2009), Sec. 8.5.
Limits   Where the servo limits its torque, `force_saturation` in `drive` does.
"""

from __future__ import annotations

from typing import Any

from ..framework.arithmetic import Arithmetic
from ..framework.model import InputHold, Model, Slot, SlotFunction, Values, no_effect
from ..framework.variables import choice, declare, input_, parameter, state


class PositionServo(Model):
    """See the module's text."""

    name = "position_servo"
    description = "Position servo that carries a load against gravity."
    variables = declare(
        parameter("inertia", 0.02, "kg m2", "Moment of inertia J of servo and load", above=0.0),
        parameter("stiffness", 10.0, "N m/rad", "Torque per error of position k", above=0.0),
        parameter("damping", 0.3, "N m s/rad", "Viscous friction and back EMF d", minimum=0.0),
        parameter("gravity_torque", 1.0, "N m", "Weight of the load times its arm G", minimum=0.0),
        choice("input_hold", InputHold.interpolate, "What the inputs are during a step"),
        input_("q_ref", "rad", "Reference of the angle"),
        state("q", "rad", "Angle from where the load hangs", output=True),
        state("der_q", "rad/s", "Angular velocity", output=True),
    )
    slots = (
        Slot("drive", "N m", "Torque of the servo"),
        Slot("friction", "N m", "Friction of the axis", {"q": "rad", "der_q": "rad/s"}),
    )
    input_hold = "input_hold"

    def derivatives(
        self, t: Any, x: Any, u: Any, p: Any, m: Arithmetic, slot: SlotFunction = no_effect
    ) -> Values:
        drive = slot("drive", p.stiffness * (u.q_ref - x.q))
        friction = slot("friction", p.damping * x.der_q, q=x.q, der_q=x.der_q)
        return {"q": x.der_q, "der_q": (drive - friction - p.gravity_torque * m.sin(x.q)) / p.inertia}


MODEL = PositionServo()

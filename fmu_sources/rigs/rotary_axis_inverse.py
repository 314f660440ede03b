"""
Inverse of the rotary axis: the torque that a measured motion asks for.

    torque = J q'' + F,   F = b q'  (slot `friction`)

Inputs   q [rad], der_q [rad/s], der_der_q [rad/s2]   smoothed without phase from the recorded angle
Outputs  torque [N m]                                 direct feedthrough: all inputs
States   none (effects bring theirs)
Slots    friction: b q', of q and der_q
Source   Inverse dynamics with least squares; Khalil, Dombre, Modeling, Identification and Control of Robots
         (2002), Ch. 12.
"""

from __future__ import annotations

from typing import Any

from ..framework.arithmetic import Arithmetic
from ..framework.model import InputHold, Model, Slot, SlotFunction, Values, no_effect
from ..framework.variables import choice, declare, input_, output, parameter


class RotaryAxisInverse(Model):
    """See the module's text."""

    name = "rotary_axis_inverse"
    description = "The torque that a measured motion of a rotary axis asks for."
    variables = declare(
        parameter("inertia", 0.01, "kg m2", "Moment of inertia J of all that turns", above=0.0),
        parameter("damping", 0.01, "N m s/rad", "Viscous friction b", minimum=0.0),
        choice("input_hold", InputHold.interpolate, "What the inputs are during a step"),
        input_("q", "rad", "Angle"),
        input_("der_q", "rad/s", "Angular velocity"),
        input_("der_der_q", "rad/s2", "Angular acceleration"),
        output("torque", "N m", "Torque of the drive"),
    )
    slots = (Slot("friction", "N m", "Friction of the axis", {"q": "rad", "der_q": "rad/s"}),)
    input_hold = "input_hold"

    def outputs(
        self, t: Any, x: Any, u: Any, p: Any, m: Arithmetic, slot: SlotFunction = no_effect
    ) -> Values:
        friction = slot("friction", p.damping * u.der_q, q=u.q, der_q=u.der_q)
        return {"torque": p.inertia * u.der_der_q + friction}


MODEL = RotaryAxisInverse()

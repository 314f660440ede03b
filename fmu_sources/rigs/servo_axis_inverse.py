"""
Inverse of the servo axis: the force that a measured motion asks for.

    F = M q'' + f,   f = c q'  (slot `friction`)

Inputs   q [m], der_q [m/s], der_der_q [m/s2]   smoothed without phase from the recorded position
Outputs  force [N]                              direct feedthrough: all inputs
States   none (effects bring theirs)
Slots    friction: c q', of q and der_q
Source   Janot, Gautier, Brunot, EMPS (2019): inverse dynamic model with least squares.
"""

from __future__ import annotations

from typing import Any

from ..framework.arithmetic import Arithmetic
from ..framework.model import InputHold, Model, Slot, SlotFunction, Values, no_effect
from ..framework.variables import choice, declare, input_, output, parameter


class ServoAxisInverse(Model):
    """See the module's text."""

    name = "servo_axis_inverse"
    description = "The force that a measured motion of the servo axis asks for."
    variables = declare(
        parameter("mass", 95.1, "kg", "Moving mass M", above=0.0),
        parameter("damping", 203.5, "N s/m", "Viscous friction c", minimum=0.0),
        choice("input_hold", InputHold.interpolate, "What the inputs are to states of effects during a step"),
        input_("q", "m", "Position"),
        input_("der_q", "m/s", "Velocity"),
        input_("der_der_q", "m/s2", "Acceleration"),
        output("force", "N", "Force of the drive"),
    )
    slots = (Slot("friction", "N", "Friction of the axis", {"q": "m", "der_q": "m/s"}),)
    input_hold = "input_hold"

    def outputs(
        self, t: Any, x: Any, u: Any, p: Any, m: Arithmetic, slot: SlotFunction = no_effect
    ) -> Values:
        friction = slot("friction", p.damping * u.der_q, q=u.q, der_q=u.der_q)
        return {"force": p.mass * u.der_der_q + friction}


MODEL = ServoAxisInverse()

"""
Rotary axis that a motor drives by its current.

    J q'' = k_t i - F,   F = b q'  (slot `friction`)

Inputs   i [A]
Outputs  q [rad], der_q [rad/s] (states)    direct feedthrough: none
States   q, der_q                           start: 0
Slots    friction: b q', of q and der_q
Source   Newton's second law for rotation; Craig, Introduction to Robotics (2005), Sec. 9.10.
Limits   Open loop, it integrates twice: replay it in windows with estimated starts.
"""

from __future__ import annotations

from typing import Any

from ..framework.arithmetic import Arithmetic
from ..framework.model import InputHold, Model, Slot, SlotFunction, Values, no_effect
from ..framework.variables import choice, declare, input_, parameter, state


class RotaryAxis(Model):
    """See the module's text."""

    name = "rotary_axis"
    description = "Rotary axis that a motor drives by its current."
    variables = declare(
        parameter("inertia", 0.01, "kg m2", "Moment of inertia J of all that turns", above=0.0),
        parameter("damping", 0.01, "N m s/rad", "Viscous friction b", minimum=0.0),
        parameter("torque_constant", 0.1, "N m/A", "Torque per current k_t", above=0.0),
        choice("input_hold", InputHold.interpolate, "What the inputs are during a step"),
        input_("i", "A", "Current of the motor"),
        state("q", "rad", "Angle", output=True),
        state("der_q", "rad/s", "Angular velocity", output=True),
    )
    slots = (Slot("friction", "N m", "Friction of the axis", {"q": "rad", "der_q": "rad/s"}),)
    input_hold = "input_hold"

    def derivatives(
        self, t: Any, x: Any, u: Any, p: Any, m: Arithmetic, slot: SlotFunction = no_effect
    ) -> Values:
        friction = slot("friction", p.damping * x.der_q, q=x.q, der_q=x.der_q)
        return {"q": x.der_q, "der_q": (p.torque_constant * u.i - friction) / p.inertia}


MODEL = RotaryAxis()

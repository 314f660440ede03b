"""
Pendulum with a torque at its axis.

    J q'' = torque - G sin(q) - F,   F = b q'  (slot `friction`)

Inputs   torque [N m]
Outputs  q [rad], der_q [rad/s] (states)    direct feedthrough: none
States   q, der_q                           start: 0, hanging
Slots    friction: b q', of q and der_q
Source   Newton's second law for rotation; G = m g l.
"""

from __future__ import annotations

from typing import Any

from ..framework.arithmetic import Arithmetic
from ..framework.model import InputHold, Model, Slot, SlotFunction, Values, no_effect
from ..framework.variables import choice, declare, input_, parameter, state


class Pendulum(Model):
    """See the module's text."""

    name = "pendulum"
    description = "Pendulum with a torque at its axis."
    variables = declare(
        parameter("inertia", 0.1, "kg m2", "Moment of inertia J about the axis", above=0.0),
        parameter("damping", 0.001, "N m s/rad", "Viscous friction b", minimum=0.0),
        parameter("gravity_torque", 2.0, "N m", "Weight times its arm G = m g l", above=0.0),
        choice("input_hold", InputHold.interpolate, "What the inputs are during a step"),
        input_("torque", "N m", "Torque at the axis"),
        state("q", "rad", "Angle from where it hangs", output=True),
        state("der_q", "rad/s", "Angular velocity", output=True),
    )
    slots = (Slot("friction", "N m", "Friction of the axis", {"q": "rad", "der_q": "rad/s"}),)
    input_hold = "input_hold"

    def derivatives(
        self, t: Any, x: Any, u: Any, p: Any, m: Arithmetic, slot: SlotFunction = no_effect
    ) -> Values:
        friction = slot("friction", p.damping * x.der_q, q=x.q, der_q=x.der_q)
        return {"q": x.der_q, "der_q": (u.torque - p.gravity_torque * m.sin(x.q) - friction) / p.inertia}


MODEL = Pendulum()

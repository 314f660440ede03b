"""
Motor with a commutator from voltage to speed.

    L i' = u - R i - k q'
    J q'' = k i - F,   F = b q'  (slot `friction`)

Inputs   u [V]
Outputs  i [A], q [rad], der_q [rad/s] (states)    direct feedthrough: none
States   i, q, der_q                               start: 0
Slots    friction: b q', of q and der_q
Source   Franklin, Powell, Emami-Naeini, Feedback Control of Dynamic Systems (2015), Sec. 2.3.
Limits   Constants of torque and back EMF are equal, which they are in SI.
"""

from __future__ import annotations

from typing import Any

from ..framework.arithmetic import Arithmetic
from ..framework.model import InputHold, Model, Slot, SlotFunction, Values, no_effect
from ..framework.variables import choice, declare, input_, parameter, state


class DcMotor(Model):
    """See the module's text."""

    name = "dc_motor"
    description = "Motor with a commutator from voltage to speed."
    variables = declare(
        parameter("resistance", 1.0, "Ohm", "Resistance of the armature R", above=0.0),
        parameter("inductance", 1e-3, "H", "Inductance of the armature L", above=0.0),
        parameter(
            "motor_constant", 0.05, "N m/A", "Torque per current, and back EMF per speed, k", above=0.0
        ),
        parameter("inertia", 1e-4, "kg m2", "Moment of inertia J", above=0.0),
        parameter("damping", 1e-5, "N m s/rad", "Viscous friction b", minimum=0.0),
        choice("input_hold", InputHold.interpolate, "What the inputs are during a step"),
        input_("u", "V", "Voltage of the armature"),
        state("i", "A", "Current", output=True),
        state("q", "rad", "Angle", output=True),
        state("der_q", "rad/s", "Angular velocity", output=True),
    )
    slots = (Slot("friction", "N m", "Friction of the shaft", {"q": "rad", "der_q": "rad/s"}),)
    input_hold = "input_hold"

    def derivatives(
        self, t: Any, x: Any, u: Any, p: Any, m: Arithmetic, slot: SlotFunction = no_effect
    ) -> Values:
        friction = slot("friction", p.damping * x.der_q, q=x.q, der_q=x.der_q)
        return {
            "i": (u.u - p.resistance * x.i - p.motor_constant * x.der_q) / p.inductance,
            "q": x.der_q,
            "der_q": (p.motor_constant * x.i - friction) / p.inertia,
        }


MODEL = DcMotor()

"""
Position servo that holds a rod against its weight: a motor with a proportional controller.

    J phi'' = k_t/R (V - k_t phi') - m g l sin(phi) - F,   V = clip(k_p (phi_ref - phi), V_max)
    F = c phi'  (slot `friction`)

Inputs   phi_ref [rad]
Outputs  phi [rad], der_phi [rad/s] (states)   direct feedthrough: none
States   phi, der_phi                          start: 0; phi = 0 hangs down
Slots    friction: c phi', of phi and der_phi
Source   DC motor without inductance; Newton's law for rotation.
Limits   Backlash, Stribeck and load-dependent friction are effects.
"""

from __future__ import annotations

from typing import Any

from ..effects.framework.shapes import clip
from ..framework.arithmetic import Arithmetic
from ..framework.model import Model, Slot, SlotFunction, Values, no_effect
from ..framework.variables import declare, input_, parameter, state
from .hold import held, input_hold


class PositionServo(Model):
    """See the module's text."""

    name = "position_servo"
    description = "Position servo that holds a rod against its weight."
    variables = declare(
        parameter("inertia", 0.02, "kg m2", "Moment of inertia J with rotor and load", above=0.0),
        parameter("weight_moment", 0.5, "N m", "Moment m g l of the weight", minimum=0.0),
        parameter("torque_constant", 0.8, "N m/A", "Torque constant k_t at the output", above=0.0),
        parameter("resistance", 2.0, "Ohm", "Resistance R", above=0.0),
        parameter("position_gain", 30.0, "V/rad", "Gain k_p of the controller", minimum=0.0),
        parameter("largest_voltage", 12.0, "V", "Limit V_max", above=0.0),
        parameter("damping", 0.05, "N m s/rad", "Viscous friction c", minimum=0.0),
        input_("phi_ref", "rad", "Angle that is asked for"),
        state("phi", "rad", "Angle", output=True),
        state("der_phi", "rad/s", "Angular velocity", output=True),
        input_hold(),
    )
    slots = (Slot("friction", "N m", "Friction of motor and gear", {"phi": "rad", "der_phi": "rad/s"}),)
    delays = held("phi_ref")
    input_hold = "input_hold"

    def derivatives(
        self, t: Any, x: Any, u: Any, p: Any, m: Arithmetic, slot: SlotFunction = no_effect
    ) -> Values:
        voltage = clip(p.position_gain * (u.phi_ref - x.phi), -p.largest_voltage, p.largest_voltage, m)
        current = (voltage - p.torque_constant * x.der_phi) / p.resistance
        friction = slot("friction", p.damping * x.der_phi, phi=x.phi, der_phi=x.der_phi)
        torque = p.torque_constant * current - p.weight_moment * m.sin(x.phi) - friction
        return {"phi": x.der_phi, "der_phi": torque / p.inertia}


MODEL = PositionServo()

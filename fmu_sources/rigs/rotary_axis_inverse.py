"""
Inverse of the rotary axis: the torque that a measured motion asks for.

    M = J phi'' + F,   F = c phi'  (slot `friction`)

Inputs   phi [rad], der_phi [rad/s], der_der_phi [rad/s2]
Outputs  torque M [N m]            direct feedthrough: all inputs
States   none (effects bring theirs)
Slots    friction: c phi', of phi and der_phi
Source   Newton's law for rotation.
"""

from __future__ import annotations

from typing import Any

from ..framework.arithmetic import Arithmetic
from ..framework.model import Model, Slot, SlotFunction, Values, no_effect
from ..framework.variables import declare, input_, output, parameter
from .hold import held, input_hold


class RotaryAxisInverse(Model):
    """See the module's text."""

    name = "rotary_axis_inverse"
    description = "The torque that a measured motion of a rotary axis asks for."
    variables = declare(
        parameter("inertia", 0.05, "kg m2", "Moment of inertia J", above=0.0),
        parameter("damping", 0.02, "N m s/rad", "Viscous friction c", minimum=0.0),
        input_("phi", "rad", "Angle"),
        input_("der_phi", "rad/s", "Angular velocity"),
        input_("der_der_phi", "rad/s2", "Angular acceleration"),
        output("torque", "N m", "Torque M"),
        input_hold(),
    )
    slots = (Slot("friction", "N m", "Friction of the axis", {"phi": "rad", "der_phi": "rad/s"}),)
    delays = held("phi", "der_phi", "der_der_phi")
    input_hold = "input_hold"

    def outputs(
        self, t: Any, x: Any, u: Any, p: Any, m: Arithmetic, slot: SlotFunction = no_effect
    ) -> Values:
        friction = slot("friction", p.damping * u.der_phi, phi=u.phi, der_phi=u.der_phi)
        return {"torque": p.inertia * u.der_der_phi + friction}


MODEL = RotaryAxisInverse()

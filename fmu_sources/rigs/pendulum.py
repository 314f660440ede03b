"""
Pendulum driven by a torque.

    J phi'' = M - m g l sin(phi) - F,   F = c phi'  (slot `friction`)

Inputs   torque M [N m]
Outputs  phi [rad], der_phi [rad/s] (states)   direct feedthrough: none
States   phi, der_phi                          start: 0; phi = 0 hangs down
Slots    friction: c phi', of phi and der_phi
Source   Newton's law for rotation.
"""

from __future__ import annotations

from typing import Any

from ..framework.arithmetic import Arithmetic
from ..framework.model import Model, Slot, SlotFunction, Values, no_effect
from ..framework.variables import declare, input_, parameter, state
from .hold import held, input_hold


class Pendulum(Model):
    """See the module's text."""

    name = "pendulum"
    description = "Pendulum driven by a torque."
    variables = declare(
        parameter("inertia", 0.25, "kg m2", "Moment of inertia J about the pivot", above=0.0),
        parameter("weight_moment", 4.905, "N m", "Moment m g l of the weight", minimum=0.0),
        parameter("damping", 0.01, "N m s/rad", "Viscous friction c", minimum=0.0),
        input_("torque", "N m", "Torque M"),
        state("phi", "rad", "Angle", output=True),
        state("der_phi", "rad/s", "Angular velocity", output=True),
        input_hold(),
    )
    slots = (Slot("friction", "N m", "Friction of the pivot", {"phi": "rad", "der_phi": "rad/s"}),)
    delays = held("torque")
    input_hold = "input_hold"

    def derivatives(
        self, t: Any, x: Any, u: Any, p: Any, m: Arithmetic, slot: SlotFunction = no_effect
    ) -> Values:
        friction = slot("friction", p.damping * x.der_phi, phi=x.phi, der_phi=x.der_phi)
        torque = u.torque - p.weight_moment * m.sin(x.phi) - friction
        return {"phi": x.der_phi, "der_phi": torque / p.inertia}


MODEL = Pendulum()

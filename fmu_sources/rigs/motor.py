"""
DC motor from voltage to speed.

    L i' = V - R i - k w,   J w' = k i - F,   F = c w  (slot `friction`)

Inputs   voltage V [V]
Outputs  current i [A], der_phi w [rad/s] (states)   direct feedthrough: none
States   current, der_phi                            start: 0
Slots    friction: c w, of der_phi
Source   Kirchhoff's and Newton's laws; k is the torque constant and that of the back-EMF.
"""

from __future__ import annotations

from typing import Any

from ..framework.arithmetic import Arithmetic
from ..framework.model import Model, Slot, SlotFunction, Values, no_effect
from ..framework.variables import declare, input_, parameter, state
from .hold import held, input_hold


class Motor(Model):
    """See the module's text."""

    name = "motor"
    description = "DC motor from voltage to speed."
    variables = declare(
        parameter("inductance", 1e-3, "H", "Inductance L", above=0.0),
        parameter("resistance", 1.0, "Ohm", "Resistance R", above=0.0),
        parameter("torque_constant", 0.05, "N m/A", "Torque constant k", above=0.0),
        parameter("inertia", 1e-4, "kg m2", "Moment of inertia J", above=0.0),
        parameter("damping", 1e-5, "N m s/rad", "Viscous friction c", minimum=0.0),
        input_("voltage", "V", "Voltage V"),
        state("current", "A", "Current i", output=True),
        state("der_phi", "rad/s", "Speed w", output=True),
        input_hold(),
    )
    slots = (Slot("friction", "N m", "Friction of the rotor", {"der_phi": "rad/s"}),)
    delays = held("voltage")
    input_hold = "input_hold"

    def derivatives(
        self, t: Any, x: Any, u: Any, p: Any, m: Arithmetic, slot: SlotFunction = no_effect
    ) -> Values:
        friction = slot("friction", p.damping * x.der_phi, der_phi=x.der_phi)
        drop = u.voltage - p.resistance * x.current - p.torque_constant * x.der_phi
        torque = p.torque_constant * x.current - friction
        return {"current": drop / p.inductance, "der_phi": torque / p.inertia}


MODEL = Motor()

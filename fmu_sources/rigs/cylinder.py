"""
Pneumatic or hydraulic cylinder, driven by the pressures that were measured in its chambers.

    M q'' = A_1 p_1 - A_2 p_2 - F - F_0,   F = c q'  (slot `friction`)

Inputs   p_1, p_2 [Pa]             pressures over that outside
Outputs  q [m], der_q [m/s] (states)   direct feedthrough: none
States   q, der_q                  start: 0
Slots    friction: c q', of q and der_q
Source   Newton's law; the gas or oil is in the pressures.
Limits   Ends of the stroke are an effect (`end_stop`). F_0 is a weight or a constant load.
"""

from __future__ import annotations

from typing import Any

from ..framework.arithmetic import Arithmetic
from ..framework.model import Model, Slot, SlotFunction, Values, no_effect
from ..framework.variables import declare, input_, parameter, state
from .hold import held, input_hold


class Cylinder(Model):
    """See the module's text."""

    name = "cylinder"
    description = "Cylinder driven by the pressures in its chambers."
    variables = declare(
        parameter("mass", 5.0, "kg", "Moving mass M", above=0.0),
        parameter("area_1", 8e-4, "m2", "Area A_1 of the piston", above=0.0),
        parameter("area_2", 6.9e-4, "m2", "Area A_2 on the side of the rod", minimum=0.0),
        parameter("damping", 100.0, "N s/m", "Viscous friction c", minimum=0.0),
        parameter("load", 0.0, "N", "Constant load F_0 against the motion of p_1"),
        input_("p_1", "Pa", "Pressure that pushes out"),
        input_("p_2", "Pa", "Pressure that pushes in"),
        state("q", "m", "Position", output=True),
        state("der_q", "m/s", "Velocity", output=True),
        input_hold(),
    )
    slots = (Slot("friction", "N", "Friction of the seals", {"q": "m", "der_q": "m/s"}),)
    delays = held("p_1", "p_2")
    input_hold = "input_hold"

    def derivatives(
        self, t: Any, x: Any, u: Any, p: Any, m: Arithmetic, slot: SlotFunction = no_effect
    ) -> Values:
        friction = slot("friction", p.damping * x.der_q, q=x.q, der_q=x.der_q)
        force = p.area_1 * u.p_1 - p.area_2 * u.p_2 - friction - p.load
        return {"q": x.der_q, "der_q": force / p.mass}


MODEL = Cylinder()

"""
Cylinder with a piston, pneumatic or hydraulic, driven by the pressures that are measured in its chambers.

    m q'' = A_a p_a - A_b p_b - load - F,   F = b q'  (slot `friction`)

Inputs   p_a, p_b [Pa], load [N]            pressures over that of the surroundings
Outputs  q [m], der_q [m/s] (states)        direct feedthrough: none
States   q, der_q                           start: 0
Slots    friction: b q', of q and der_q
Source   Merritt, Hydraulic Control Systems (1967), Sec. 6-1.
Limits   The piston does not reach its ends (`end_stop` is an effect); how a valve makes the pressures is not
         in it.
"""

from __future__ import annotations

from typing import Any

from ..framework.arithmetic import Arithmetic
from ..framework.model import InputHold, Model, Slot, SlotFunction, Values, no_effect
from ..framework.variables import choice, declare, input_, parameter, state


class Cylinder(Model):
    """See the module's text."""

    name = "cylinder"
    description = "Cylinder driven by the pressures in its chambers."
    variables = declare(
        parameter("mass", 10.0, "kg", "Moving mass m", above=0.0),
        parameter("damping", 100.0, "N s/m", "Viscous friction b of seals", minimum=0.0),
        parameter("area_a", 1e-3, "m2", "Area A_a of the piston towards p_a", above=0.0),
        parameter("area_b", 1e-3, "m2", "Area A_b of the piston towards p_b", above=0.0),
        choice("input_hold", InputHold.interpolate, "What the inputs are during a step"),
        input_("p_a", "Pa", "Pressure that pushes the piston out"),
        input_("p_b", "Pa", "Pressure that pushes it back"),
        input_("load", "N", "Force against the motion outwards"),
        state("q", "m", "Displacement of the piston", output=True),
        state("der_q", "m/s", "Velocity of the piston", output=True),
    )
    slots = (Slot("friction", "N", "Friction of the seals", {"q": "m", "der_q": "m/s"}),)
    input_hold = "input_hold"

    def derivatives(
        self, t: Any, x: Any, u: Any, p: Any, m: Arithmetic, slot: SlotFunction = no_effect
    ) -> Values:
        friction = slot("friction", p.damping * x.der_q, q=x.q, der_q=x.der_q)
        push = p.area_a * u.p_a - p.area_b * u.p_b - u.load
        return {"q": x.der_q, "der_q": (push - friction) / p.mass}


MODEL = Cylinder()

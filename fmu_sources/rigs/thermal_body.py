"""
Body that is heated and loses heat to its surroundings.

    C T' = P - F,   F = h (T - T_a)  (slot `heat_loss`)

Inputs   power P [W], ambient T_a [K]
Outputs  temperature T [K] (state)     direct feedthrough: none
States   temperature                   start: 293.15 K
Slots    heat_loss: h (T - T_a), of the excess T - T_a and its rate as the linear law has it with T_a at rest
Source   Balance of energy of a body without gradients inside.
Deviation  Radiation is an effect (`power_law` of the excess).
"""

from __future__ import annotations

from typing import Any

from ..framework.arithmetic import Arithmetic
from ..framework.model import Model, Slot, SlotFunction, Values, no_effect
from ..framework.variables import declare, input_, parameter, state
from .hold import held, input_hold


class ThermalBody(Model):
    """See the module's text."""

    name = "thermal_body"
    description = "Body that is heated and loses heat."
    variables = declare(
        parameter("capacity", 500.0, "J/K", "Heat capacity C", above=0.0),
        parameter("heat_loss", 2.0, "W/K", "Heat loss h per kelvin", minimum=0.0),
        input_("power", "W", "Heating power P"),
        input_("ambient", "K", "Temperature T_a of the surroundings", start=293.15),
        state("temperature", "K", "Temperature T", start=293.15, output=True),
        input_hold(),
    )
    slots = (Slot("heat_loss", "W", "Heat that is lost", {"excess": "K", "der_excess": "K/s"}),)
    delays = held("power", "ambient")
    input_hold = "input_hold"
    substep = 0.5  # s: temperatures change over minutes

    def derivatives(
        self, t: Any, x: Any, u: Any, p: Any, m: Arithmetic, slot: SlotFunction = no_effect
    ) -> Values:
        excess = x.temperature - u.ambient
        linear = p.heat_loss * excess
        lost = slot("heat_loss", linear, excess=excess, der_excess=(u.power - linear) / p.capacity)
        return {"temperature": (u.power - lost) / p.capacity}


MODEL = ThermalBody()

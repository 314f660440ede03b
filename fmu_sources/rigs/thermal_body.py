"""
Body that is heated and loses heat to its surroundings.

    C T' = P - loss,   loss = G (T - T_a)  (slot `loss`)

Inputs   power [W], ambient [K]
Outputs  temperature [K] (state)     direct feedthrough: none
States   temperature                 start: 293.15 K
Slots    loss: G (T - T_a), of rise = T - T_a (a position without a rate)
Source   Newton's law of cooling; Incropera et al., Heat and Mass Transfer (2007), Ch. 5.
Limits   One temperature: the body conducts better than its surface loses heat.
"""

from __future__ import annotations

from typing import Any

from ..framework.arithmetic import Arithmetic
from ..framework.model import InputHold, Model, Slot, SlotFunction, Values, no_effect
from ..framework.variables import choice, declare, input_, parameter, state


class ThermalBody(Model):
    """See the module's text."""

    name = "thermal_body"
    description = "Body that is heated and loses heat to its surroundings."
    variables = declare(
        parameter("heat_capacity", 500.0, "J/K", "Heat capacity C", above=0.0),
        parameter("conductance", 1.0, "W/K", "Heat that is lost per degree G", minimum=0.0),
        choice("input_hold", InputHold.interpolate, "What the inputs are during a step"),
        input_("power", "W", "Heating"),
        input_("ambient", "K", "Temperature of the surroundings", start=293.15),
        state("temperature", "K", "Temperature of the body", output=True, start=293.15),
    )
    slots = (Slot("loss", "W", "Heat that is lost", {"rise": "K"}, position="rise"),)
    input_hold = "input_hold"
    substep = 1.0  # s: a body cools in minutes

    def derivatives(
        self, t: Any, x: Any, u: Any, p: Any, m: Arithmetic, slot: SlotFunction = no_effect
    ) -> Values:
        rise = x.temperature - u.ambient
        loss = slot("loss", p.conductance * rise, rise=rise)
        return {"temperature": (u.power - loss) / p.heat_capacity}


MODEL = ThermalBody()

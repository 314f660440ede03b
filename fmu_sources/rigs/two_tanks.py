"""
Level process: a pump fills an upper tank, which runs into a lower one.

    h_1' = k u - q_1,   q_1 = c_1 h_1  (slot `upper_outflow`)
    h_2' = r q_1 - q_2,   q_2 = c_2 h_2  (slot `lower_outflow`)

Inputs   u [V]                        voltage of the pump
Outputs  h_1, h_2 [V] (states)        levels as their sensors give them; direct feedthrough: none
States   h_1, h_2                     start: 0
Slots    upper_outflow: c_1 h_1, of h_1;  lower_outflow: c_2 h_2, of h_2 (positions without a rate)
Source   Wigren, Schoukens, Three free data sets (2013); Schoukens, Noel, Cascaded tanks (2016).
Deviation  There both outflows go with the square root of the level; that is an effect here (`power_law`).
Limits   Levels stay above 0. What flows over an edge is an effect (`overflow`).
"""

from __future__ import annotations

from typing import Any

from ..framework.arithmetic import Arithmetic
from ..framework.model import InputHold, Model, Slot, SlotFunction, Values, no_effect
from ..framework.variables import choice, declare, input_, parameter, state


class TwoTanks(Model):
    """See the module's text."""

    name = "two_tanks"
    description = "A pump, an upper tank and a lower one."
    variables = declare(
        parameter("pump_gain", 0.04, "1/s", "Rise of the upper level per voltage k", above=0.0),
        parameter("upper_rate", 0.01, "1/s", "Outflow of the upper tank per level c_1", minimum=0.0),
        parameter("ratio", 1.0, "1", "Area of the upper tank over that of the lower one r", above=0.0),
        parameter("lower_rate", 0.01, "1/s", "Outflow of the lower tank per level c_2", minimum=0.0),
        choice("input_hold", InputHold.interpolate, "What the inputs are during a step"),
        input_("u", "V", "Voltage of the pump"),
        state("h_1", "V", "Level of the upper tank", output=True),
        state("h_2", "V", "Level of the lower tank", output=True),
    )
    slots = (
        Slot("upper_outflow", "V/s", "What runs out of the upper tank", {"h_1": "V"}, position="h_1"),
        Slot("lower_outflow", "V/s", "What runs out of the lower tank", {"h_2": "V"}, position="h_2"),
    )
    input_hold = "input_hold"
    substep = 0.5  # s: the fastest outflow takes seconds

    def derivatives(
        self, t: Any, x: Any, u: Any, p: Any, m: Arithmetic, slot: SlotFunction = no_effect
    ) -> Values:
        upper = slot("upper_outflow", p.upper_rate * x.h_1, h_1=x.h_1)
        lower = slot("lower_outflow", p.lower_rate * x.h_2, h_2=x.h_2)
        return {"h_1": p.pump_gain * u.u - upper, "h_2": p.ratio * upper - lower}


MODEL = TwoTanks()

"""
Level process: two tanks, one above the other.

    A_1 h_1' = k u - q_1,   q_1 = r_1 h_1  (slot `outflow_1`)
    A_2 h_2' = q_1 - q_2,   q_2 = r_2 h_2  (slot `outflow_2`)

Inputs   u [V]                     voltage of the pump
Outputs  h_1, h_2 [m] (states)     direct feedthrough: none
States   h_1, h_2                  start: 0
Slots    outflow_1, outflow_2: r h, of h and its rate as the linear law has it
Source   Balance of mass; Wigren, Schoukens, Three free data sets (2013), Cascaded tanks.
Deviation  The outflow is linear here; Torricelli's is an effect (`power_law`), overflow another (`overflow`).
"""

from __future__ import annotations

from typing import Any

from ..framework.arithmetic import Arithmetic
from ..framework.model import Model, Slot, SlotFunction, Values, no_effect
from ..framework.variables import declare, input_, parameter, state
from .hold import held, input_hold


class TwoTanks(Model):
    """See the module's text."""

    name = "two_tanks"
    description = "Level process: two tanks, one above the other."
    variables = declare(
        parameter("area_1", 0.01, "m2", "Area A_1 of the upper tank", above=0.0),
        parameter("area_2", 0.01, "m2", "Area A_2 of the lower tank", above=0.0),
        parameter("pump_gain", 1e-5, "m3/(V s)", "Flow k per volt", minimum=0.0),
        parameter("outflow_rate_1", 1e-4, "m2/s", "Outflow r_1 per level", minimum=0.0),
        parameter("outflow_rate_2", 1e-4, "m2/s", "Outflow r_2 per level", minimum=0.0),
        input_("u", "V", "Voltage of the pump"),
        state("h_1", "m", "Level of the upper tank", output=True),
        state("h_2", "m", "Level of the lower tank", output=True),
        input_hold(),
    )
    slots = (
        Slot("outflow_1", "m3/s", "Outflow of the upper tank", {"h": "m", "der_h": "m/s"}),
        Slot("outflow_2", "m3/s", "Outflow of the lower tank", {"h": "m", "der_h": "m/s"}),
    )
    delays = held("u")
    input_hold = "input_hold"
    substep = 0.1  # s: levels change over minutes

    def derivatives(
        self, t: Any, x: Any, u: Any, p: Any, m: Arithmetic, slot: SlotFunction = no_effect
    ) -> Values:
        linear_1, linear_2 = p.outflow_rate_1 * x.h_1, p.outflow_rate_2 * x.h_2
        inflow = p.pump_gain * u.u
        q_1 = slot("outflow_1", linear_1, h=x.h_1, der_h=(inflow - linear_1) / p.area_1)
        q_2 = slot("outflow_2", linear_2, h=x.h_2, der_h=(q_1 - linear_2) / p.area_2)
        return {"h_1": (inflow - q_1) / p.area_1, "h_2": (q_1 - q_2) / p.area_2}


MODEL = TwoTanks()

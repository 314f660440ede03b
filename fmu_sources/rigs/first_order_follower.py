"""
What follows its input with a lag of first order: a heater's sensor, a proportional valve, a filter.

    T y' = g u + y_0 - y,   g u + y_0 in slot `aim`

Inputs   u [1]
Outputs  y [1] (state)      direct feedthrough: none
States   y                  start: 0
Slots    aim: g u + y_0
Source   Linear system of first order.
Limits   Input and output in any units: declare them as 1 in the case.
"""

from __future__ import annotations

from typing import Any

from ..framework.arithmetic import Arithmetic
from ..framework.model import InputHold, Model, Slot, SlotFunction, Values, no_effect
from ..framework.variables import choice, declare, input_, parameter, state


class FirstOrderFollower(Model):
    """See the module's text."""

    name = "first_order_follower"
    description = "What follows its input with a lag of first order."
    variables = declare(
        parameter("time_constant", 0.1, "s", "Time constant T", above=0.0),
        parameter("gain", 1.0, "1", "Gain g"),
        parameter("zero", 0.0, "1", "Output y_0 where the input is 0 for long"),
        choice("input_hold", InputHold.interpolate, "What the inputs are during a step"),
        input_("u", "1", "Input"),
        state("y", "1", "Output", output=True),
    )
    slots = (Slot("aim", "1", "Where the output goes"),)
    input_hold = "input_hold"

    def derivatives(
        self, t: Any, x: Any, u: Any, p: Any, m: Arithmetic, slot: SlotFunction = no_effect
    ) -> Values:
        aim = slot("aim", p.gain * u.u + p.zero)
        return {"y": (aim - x.y) / p.time_constant}


MODEL = FirstOrderFollower()

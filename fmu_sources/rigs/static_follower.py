"""
What follows its input at once: an amplifier, a scale, a valve that is fast.

    y = g u + y_0  (slot `answer`)

Inputs   u [1]
Outputs  y [1]       direct feedthrough: u
States   none (effects bring theirs)
Slots    answer: g u + y_0
Source   A straight line.
Limits   Input and output in any units: declare them as 1 in the case.
"""

from __future__ import annotations

from typing import Any

from ..framework.arithmetic import Arithmetic
from ..framework.model import InputHold, Model, Slot, SlotFunction, Values, no_effect
from ..framework.variables import choice, declare, input_, output, parameter


class StaticFollower(Model):
    """See the module's text."""

    name = "static_follower"
    description = "What follows its input at once."
    variables = declare(
        parameter("gain", 1.0, "1", "Gain g"),
        parameter("zero", 0.0, "1", "Output y_0 where the input is 0"),
        choice("input_hold", InputHold.interpolate, "What the inputs are during a step"),
        input_("u", "1", "Input"),
        output("y", "1", "Output"),
    )
    slots = (Slot("answer", "1", "What is answered"),)
    input_hold = "input_hold"

    def outputs(
        self, t: Any, x: Any, u: Any, p: Any, m: Arithmetic, slot: SlotFunction = no_effect
    ) -> Values:
        return {"y": slot("answer", p.gain * u.u + p.zero)}


MODEL = StaticFollower()

"""
What follows a command with a gain and a first-order lag: a valve, a sensor, a heated plate.

    T y' = K u - y,   output z = y + z_0  (slot `value`)

Inputs   u [1]
Outputs  z [1]                     direct feedthrough: none
States   y                         start: 0
Slots    value: the output on its way
Source   First-order lag.
Deviation  A dead time is an effect here (`extra_delay`). With T far below the step it is a static gain.
Limits   Numbers of any unit: units of a case are those of its signals with `unit: 1`.
"""

from __future__ import annotations

from typing import Any

from ..framework.arithmetic import Arithmetic
from ..framework.model import Model, Slot, SlotFunction, Values, no_effect
from ..framework.variables import declare, input_, output, parameter, state
from .hold import held, input_hold


class Follower(Model):
    """See the module's text."""

    name = "follower"
    description = "What follows a command with a gain and a first-order lag."
    variables = declare(
        parameter("gain", 1.0, "1", "Gain K"),
        parameter("lag", 0.1, "s", "Time constant T", above=0.0),
        parameter("offset", 0.0, "1", "Offset z_0 of the output"),
        input_("u", "1", "Command"),
        state("y", "1", "Value that follows"),
        output("z", "1", "Output"),
        input_hold(),
    )
    slots = (Slot("value", "1", "Output on its way"),)
    delays = held("u")
    input_hold = "input_hold"

    def derivatives(
        self, t: Any, x: Any, u: Any, p: Any, m: Arithmetic, slot: SlotFunction = no_effect
    ) -> Values:
        return {"y": (p.gain * u.u - x.y) / p.lag}

    def outputs(
        self, t: Any, x: Any, u: Any, p: Any, m: Arithmetic, slot: SlotFunction = no_effect
    ) -> Values:
        return {"z": slot("value", x.y + p.offset)}


MODEL = Follower()

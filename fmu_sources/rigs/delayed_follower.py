"""
What follows its input after a dead time: a conveyor, a pipe, a network.

    y(t) = g u(t - dead_time) + y_0  (slot `answer`)

The input is held over each sampling period T; the dead time is round(dead_time/T) periods.

Inputs   u [1]
Outputs  y [1]       direct feedthrough: none
States   the delay line value[i] [1]: input of i periods ago. Start: filled with u
Slots    answer: g u(t - dead_time) + y_0
Source   Smith, Closer control of loops with dead time (1957).
Limits   Input and output in any units: declare them as 1 in the case. At most 99 periods; it answers one
         period late at least.
"""

from __future__ import annotations

from typing import Any

from ..framework.arithmetic import Arithmetic
from ..framework.model import Delay, Model, Slot, SlotFunction, Values, no_effect
from ..framework.variables import declare, fixed, input_, output, parameter, sampled, state, vector

LINE_LENGTH = 100


class DelayedFollower(Model):
    """See the module's text."""

    name = "delayed_follower"
    description = "What follows its input after a dead time."
    variables = declare(
        parameter("gain", 1.0, "1", "Gain g"),
        parameter("zero", 0.0, "1", "Output y_0 where the input is 0"),
        parameter("dead_time", 0.01, "s", "Dead time, rounded to whole sampling periods", minimum=0.0),
        fixed(parameter("sample_time", 1e-3, "s", "Sampling period of the input", above=0.0)),
        input_("u", "1", "Input"),
        vector(sampled(state("value", "1", "Input of earlier periods"), hidden=True), LINE_LENGTH),
        output("y", "1", "Output"),
    )
    slots = (Slot("answer", "1", "What is answered"),)
    delays = (Delay(input="u", kind="dead time", seconds="dead_time", reason="delay line of whole periods"),)
    sample_time = "sample_time"

    def initial(self, x: Any, u: Any, p: Any, m: Arithmetic) -> Values:
        return {"value": (u.u,) * LINE_LENGTH}

    def update(self, t: Any, x: Any, u: Any, p: Any, m: Arithmetic, slot: SlotFunction = no_effect) -> Values:
        return {"value": (u.u, *x.value[:-1])}

    def outputs(
        self, t: Any, x: Any, u: Any, p: Any, m: Arithmetic, slot: SlotFunction = no_effect
    ) -> Values:
        periods = m.floor(p.dead_time / p.sample_time + 0.5)
        return {"y": slot("answer", p.gain * m.pick(x.value, periods - 1.0) + p.zero)}


MODEL = DelayedFollower()

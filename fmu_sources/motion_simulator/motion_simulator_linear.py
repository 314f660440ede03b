"""
Motion simulator as one linear axis: dead time of the command, position loop, velocity loop.

    M(s)   = K_p w_v^2/(s^3 + 2 z w_v s^2 + w_v^2 s + K_p w_v^2) exp(-dead_time s)
    s_act' = v_act,   v_act' = a_act
    a_act' = w_v^2 (v_cmd - v_act) - 2 z w_v a_act,   v_cmd = K_p (s_cmd(t - dead_time) - s_act)

The command is held over each sampling period T; the dead time is round(dead_time/T) periods.

Inputs   s_cmd [m]
Outputs  s_act [m], v_act [m/s]      states; direct feedthrough: none
States   s_act [m] (start settable), v_act [m/s], a_act [m/s2], delayed_command [m], the delay line
         command[i] [m]: command of i periods ago. Start: at rest in s_act, the line filled with s_act.
Source   Reduced model of Paper, Sec. III-D, Fig. 8: position P loop K_p on a velocity loop of second order
         (w_v, z), fitted to the hexapod.
Deviation  The paper uses the multibody model; this one agrees with it near 1 Hz.
Valid    Small motion near the neutral pose, no rate or force limits, no contact force on the platform.
"""

from __future__ import annotations

import math
from typing import Any

from ..framework.arithmetic import Arithmetic
from ..framework.model import Delay, Model, Slot, SlotFunction, Values, no_effect
from ..framework.variables import declare, fixed, input_, parameter, sampled, state, vector

LINE_LENGTH = 100
SHORTEST_PERIOD = 1e-3


class MotionSimulatorLinear(Model):
    """Third order with dead time."""

    name = "motion_simulator_linear"
    description = "Motion simulator, third order with dead time"
    variables = declare(
        parameter("K_p", 30.0, "1/s", "Gain of the position loop", above=0.0),
        parameter("w_v", 2 * math.pi * 20, "rad/s", "Natural frequency of the velocity loop", above=0.0),
        parameter("z", 0.8, "1", "Damping ratio of the velocity loop", above=0.0),
        parameter(
            "dead_time",
            0.002,
            "s",
            "Dead time of the command, rounded to whole sampling periods",
            minimum=0.0,
            maximum=LINE_LENGTH * SHORTEST_PERIOD,
        ),
        fixed(parameter("sample_time", 1e-3, "s", "Sampling period of the command", minimum=SHORTEST_PERIOD)),
        input_("s_cmd", "m", "Commanded displacement"),
        state("s_act", "m", "Actual displacement", output=True),
        state("v_act", "m/s", "Actual velocity", output=True),
        state("a_act", "m/s2", "Actual acceleration"),
        sampled(state("delayed_command", "m", "Command that acts in this period"), hidden=True),
        vector(sampled(state("command", "m", "Command of earlier periods"), hidden=True), LINE_LENGTH),
    )
    slots = (Slot("velocity_command", "m/s", "Velocity that the position loop asks for"),)
    delays = (
        Delay(
            input="s_cmd",
            kind="hold",
            steps=-0.5,
            reason="the command set before the step is held over the step",
        ),
        Delay(input="s_cmd", kind="dead time", seconds="dead_time", reason="delay line of whole periods"),
    )
    sample_time = "sample_time"

    def initial(self, x: Any, u: Any, p: Any, m: Arithmetic) -> Values:
        s = x.s_act
        return {"v_act": 0.0, "a_act": 0.0, "delayed_command": s, "command": (s,) * LINE_LENGTH}

    def update(self, t: Any, x: Any, u: Any, p: Any, m: Arithmetic, slot: SlotFunction = no_effect) -> Values:
        periods = m.floor(p.dead_time / p.sample_time + 0.5)
        line = (u.s_cmd, *x.command)
        return {"delayed_command": m.pick(line, periods), "command": line[:-1]}

    def derivatives(
        self, t: Any, x: Any, u: Any, p: Any, m: Arithmetic, slot: SlotFunction = no_effect
    ) -> Values:
        v_cmd = slot("velocity_command", p.K_p * (x.delayed_command - x.s_act))
        jerk = p.w_v * p.w_v * (v_cmd - x.v_act) - 2.0 * p.z * p.w_v * x.a_act
        return {"s_act": x.v_act, "v_act": x.a_act, "a_act": jerk}


MODEL = MotionSimulatorLinear()

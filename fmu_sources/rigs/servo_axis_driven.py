"""
Servo axis driven by its recorded voltage: open loop, it integrates twice and drifts.

    M q'' = g_tau v - F,   F = c q'  (slot `friction`)

Inputs   v [V]                          pulses are in the recorded v: do not add them again
Outputs  q [m], der_q [m/s] (states)    direct feedthrough: none
States   q, der_q                       start: 0
Slots    friction: c q', of q and der_q
Source   Janot, Gautier, Brunot, EMPS (2019).
Limits   Replay it in short windows with estimated start, or replay `servo_axis` in closed loop.
"""

from __future__ import annotations

from typing import Any

from ..framework.arithmetic import Arithmetic
from ..framework.model import InputHold, Model, Slot, SlotFunction, Values, no_effect
from ..framework.variables import choice, declare, input_, parameter, state


class ServoAxisDriven(Model):
    """See the module's text."""

    name = "servo_axis_driven"
    description = "Servo axis driven by its recorded voltage."
    variables = declare(
        parameter("mass", 95.1, "kg", "Moving mass M", above=0.0),
        parameter("damping", 203.5, "N s/m", "Viscous friction c", minimum=0.0),
        parameter("drive_gain", 35.15065188248547, "N/V", "Force per volt g_tau", above=0.0),
        choice("input_hold", InputHold.hold_new, "What the input is during a step"),
        input_("v", "V", "Voltage of the drive"),
        state("q", "m", "Position", output=True),
        state("der_q", "m/s", "Velocity", output=True),
    )
    slots = (Slot("friction", "N", "Friction of the axis", {"q": "m", "der_q": "m/s"}),)
    input_hold = "input_hold"

    def derivatives(
        self, t: Any, x: Any, u: Any, p: Any, m: Arithmetic, slot: SlotFunction = no_effect
    ) -> Values:
        friction = slot("friction", p.damping * x.der_q, q=x.q, der_q=x.der_q)
        return {"q": x.der_q, "der_q": (p.drive_gain * u.v - friction) / p.mass}


MODEL = ServoAxisDriven()

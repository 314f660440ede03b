"""
A force on its way between a model and what moves: it is passed on, and what moves may resist.

    y = g u + y_0 + s R   (slots `answer`: g u + y_0, and `resistance`: R = 0)

Inputs   u [N], q [m], der_q [m/s]
Outputs  y [N]       direct feedthrough: all inputs
States   none (effects bring theirs)
Slots    answer: g u + y_0, a value on its way; resistance: 0, a force of q and der_q
Source   A straight line; the side s is 1 after a model that gives the force that a motion asks for, and -1
         before one that a force moves.
Limits   For a torque read N m, rad and rad/s: connect it with `units: ignored`.
"""

from __future__ import annotations

from typing import Any

from ..framework.arithmetic import Arithmetic
from ..framework.model import InputHold, Model, Slot, SlotFunction, Values, no_effect
from ..framework.variables import choice, declare, input_, output, parameter


class MovedFollower(Model):
    """See the module's text."""

    name = "moved_follower"
    description = "A force on its way, with what moves next to it."
    variables = declare(
        parameter("gain", 1.0, "1", "Gain g"),
        parameter("zero", 0.0, "N", "Output y_0 where the input is 0"),
        parameter("side", 1.0, "1", "Side s: 1 after a model that gives the force, -1 before one it moves"),
        choice("input_hold", InputHold.interpolate, "What the inputs are during a step"),
        input_("u", "N", "Force"),
        input_("q", "m", "Position of what moves"),
        input_("der_q", "m/s", "Velocity of what moves"),
        output("y", "N", "Force after what resists"),
    )
    slots = (
        Slot("answer", "N", "What is passed on"),
        Slot("resistance", "N", "What resists the motion", {"q": "m", "der_q": "m/s"}),
    )
    input_hold = "input_hold"

    def outputs(
        self, t: Any, x: Any, u: Any, p: Any, m: Arithmetic, slot: SlotFunction = no_effect
    ) -> Values:
        passed = slot("answer", p.gain * u.u + p.zero)
        return {"y": passed + p.side * slot("resistance", 0.0, q=u.q, der_q=u.der_q)}


MODEL = MovedFollower()

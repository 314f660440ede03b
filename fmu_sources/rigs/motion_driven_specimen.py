"""
Specimen that a machine moves; what it answers is the force.

    F = k x + c x'  (slot `force`)

Inputs   x [m], der_x [m/s], load [N]   load: a normal force or band tension, if it is recorded
Outputs  force [N]                      direct feedthrough: all inputs
States   none (effects bring theirs)
Slots    force: k x + c x', of x, der_x, load
Source   Coble, Huggins, Cao, Ricles, Downey, Dataset-Friction-Damper-with-Backlash (2022): what is known
         without a look at the force is a viscous damper.
"""

from __future__ import annotations

from typing import Any

from ..framework.arithmetic import Arithmetic
from ..framework.model import Delay, InputHold, Model, Slot, SlotFunction, Values, no_effect
from ..framework.variables import choice, declare, input_, output, parameter

_HOLD = {"interpolate": 0.0, "hold_new": -0.5, "hold_old": 0.5}


class MotionDrivenSpecimen(Model):
    """See the module's text."""

    name = "motion_driven_specimen"
    description = "Specimen that a machine moves."
    variables = declare(
        parameter("stiffness", 0.0, "N/m", "Stiffness k", minimum=0.0),
        parameter("damping", 1e5, "N s/m", "Damping c", minimum=0.0),
        choice("input_hold", InputHold.interpolate, "What the inputs are to states of effects during a step"),
        input_("x", "m", "Displacement"),
        input_("der_x", "m/s", "Velocity"),
        input_("load", "N", "Normal force or band tension"),
        output("force", "N", "Force of the specimen"),
    )
    slots = (Slot("force", "N", "Force of the specimen", {"x": "m", "der_x": "m/s", "load": "N"}),)
    delays = tuple(
        Delay(name, "hold", steps=_HOLD, by="input_hold", reason="states of effects only")
        for name in ("x", "der_x", "load")
    )
    input_hold = "input_hold"

    def outputs(
        self, t: Any, x: Any, u: Any, p: Any, m: Arithmetic, slot: SlotFunction = no_effect
    ) -> Values:
        linear = p.stiffness * u.x + p.damping * u.der_x
        return {"force": slot("force", linear, x=u.x, der_x=u.der_x, load=u.load)}


MODEL = MotionDrivenSpecimen()

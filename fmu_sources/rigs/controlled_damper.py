"""
Specimen with a preload and a control signal, which a machine moves: a magnetorheological damper, a brake.

    F = F_0 + k x + (c_0 + c_1 u) x'  (slot `force`)

Inputs   x [m], der_x [m/s], control [1]   control u: a current or voltage in any unit
Outputs  force [N]                         direct feedthrough: all inputs
States   none (effects bring theirs)
Slots    force: the whole, of x and der_x
Source   Spencer, Dyke, Sain, Carlson, Phenomenological model for magnetorheological dampers (1997): what is
         known without a look at the force is a viscous damper that the current makes stiffer.
"""

from __future__ import annotations

from typing import Any

from ..framework.arithmetic import Arithmetic
from ..framework.model import InputHold, Model, Slot, SlotFunction, Values, no_effect
from ..framework.variables import choice, declare, input_, output, parameter


class ControlledDamper(Model):
    """See the module's text."""

    name = "controlled_damper"
    description = "Specimen with a preload and a control signal, which a machine moves."
    variables = declare(
        parameter("preload", 0.0, "N", "Preload F_0"),
        parameter("stiffness", 0.0, "N/m", "Stiffness k", minimum=0.0),
        parameter("damping", 1e3, "N s/m", "Damping c_0 without control", minimum=0.0),
        parameter("controlled_damping", 0.0, "N s/m", "Damping c_1 per control signal"),
        choice("input_hold", InputHold.interpolate, "What the inputs are during a step"),
        input_("x", "m", "Displacement"),
        input_("der_x", "m/s", "Velocity"),
        input_("control", "1", "Control signal"),
        output("force", "N", "Force of the specimen"),
    )
    slots = (Slot("force", "N", "Force of the specimen", {"x": "m", "der_x": "m/s"}),)
    input_hold = "input_hold"

    def outputs(
        self, t: Any, x: Any, u: Any, p: Any, m: Arithmetic, slot: SlotFunction = no_effect
    ) -> Values:
        damping = p.damping + p.controlled_damping * u.control
        linear = p.preload + p.stiffness * u.x + damping * u.der_x
        return {"force": slot("force", linear, x=u.x, der_x=u.der_x)}


MODEL = ControlledDamper()

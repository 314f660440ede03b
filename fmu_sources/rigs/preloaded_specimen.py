"""
Specimen with a preload that a machine moves, and a control signal of any unit.

    F = F_0 + (k + k_u u) x + (c + c_u u) x'  (slot `force`)

Inputs   x [m], der_x [m/s], control u [1]
Outputs  force [N]                 direct feedthrough: all inputs
States   none (effects bring theirs)
Slots    force: F, of x and der_x
Source   Kelvin-Voigt specimen; a magnetorheological damper has c_u.
Limits   The control acts at once; its own lag is an effect of the signal that is measured.
"""

from __future__ import annotations

from typing import Any

from ..framework.arithmetic import Arithmetic
from ..framework.model import Model, Slot, SlotFunction, Values, no_effect
from ..framework.variables import declare, input_, output, parameter
from .hold import held, input_hold


class PreloadedSpecimen(Model):
    """See the module's text."""

    name = "preloaded_specimen"
    description = "Specimen with a preload and a control signal."
    variables = declare(
        parameter("preload", 0.0, "N", "Preload F_0"),
        parameter("stiffness", 1e4, "N/m", "Stiffness k", minimum=0.0),
        parameter("damping", 1e3, "N s/m", "Damping c", minimum=0.0),
        parameter("stiffness_by_control", 0.0, "N/m", "Stiffness k_u per unit of the control"),
        parameter("damping_by_control", 0.0, "N s/m", "Damping c_u per unit of the control"),
        input_("x", "m", "Displacement"),
        input_("der_x", "m/s", "Velocity"),
        input_("control", "1", "Control signal u, a number of any unit"),
        output("force", "N", "Force of the specimen"),
        input_hold(),
    )
    slots = (Slot("force", "N", "Force of the specimen", {"x": "m", "der_x": "m/s"}),)
    delays = held("x", "der_x", "control")
    input_hold = "input_hold"

    def outputs(
        self, t: Any, x: Any, u: Any, p: Any, m: Arithmetic, slot: SlotFunction = no_effect
    ) -> Values:
        stiffness = p.stiffness + p.stiffness_by_control * u.control
        damping = p.damping + p.damping_by_control * u.control
        return {"force": slot("force", p.preload + stiffness * u.x + damping * u.der_x, x=u.x, der_x=u.der_x)}


MODEL = PreloadedSpecimen()

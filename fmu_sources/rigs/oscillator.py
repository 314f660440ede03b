"""
Oscillator of one degree of freedom, driven by a voltage: the circuit "Silverbox" without its hardening.

    m y'' = u - d y' - F,   F = k y  (slot `restoring_force`)

Inputs   u [V]
Outputs  y [V], der_y [V/s] (states)    direct feedthrough: none
States   y, der_y                       start: 0
Slots    restoring_force: k y, of y and der_y
Source   Wigren, Schoukens, Three free data sets for development and benchmarking in nonlinear system
         identification, ECC 2013.
Deviation  There the equation is m y'' + d y' + a y + b y^3 = u; b is an effect here (`cubic_stiffness`).
Limits   The recorded input is band limited: upsample it with a cubic spline before it is interpolated.
"""

from __future__ import annotations

from typing import Any

from ..framework.arithmetic import Arithmetic
from ..framework.model import Delay, InputHold, Model, Slot, SlotFunction, Values, no_effect
from ..framework.variables import choice, declare, input_, parameter, state


class Oscillator(Model):
    """See the module's text."""

    name = "oscillator"
    description = "Oscillator of one degree of freedom, driven by a voltage."
    variables = declare(
        parameter("mass", 5.36e-6, "s2", "Inertia m", above=0.0),
        parameter("damping", 2.24e-4, "s", "Damping d", minimum=0.0),
        parameter("stiffness", 0.987, "1", "Stiffness k", above=0.0),
        choice("input_hold", InputHold.interpolate, "What the input is during a step"),
        input_("u", "V", "Input voltage"),
        state("y", "V", "Output voltage", output=True),
        state("der_y", "V/s", "Rate of the output voltage", output=True),
    )
    slots = (Slot("restoring_force", "V", "Restoring force k y", {"y": "V", "der_y": "V/s"}),)
    delays = (
        Delay(
            "u",
            "hold",
            steps={"interpolate": 0.0, "hold_new": -0.5, "hold_old": 0.5},
            by="input_hold",
            reason="the input during a step",
        ),
    )
    input_hold = "input_hold"

    def derivatives(
        self, t: Any, x: Any, u: Any, p: Any, m: Arithmetic, slot: SlotFunction = no_effect
    ) -> Values:
        force = slot("restoring_force", p.stiffness * x.y, y=x.y, der_y=x.der_y)
        return {"y": x.der_y, "der_y": (u.u - p.damping * x.der_y - force) / p.mass}


MODEL = Oscillator()

"""
Two masses with a coupling: a drive with a shaft, a carriage with what it carries.

    m_1 q_1'' = f - K,   K = k r + c r',   r = q_1 - q_2  (slot `coupling`)
    m_2 q_2'' = K - F,   F = b q_2'  (slot `friction`)

Inputs   f [N]
Outputs  q_1, der_q_1, q_2, der_q_2 (states)    direct feedthrough: none
States   the same                               start: 0
Slots    coupling: k r + c r', of r and der_r;  friction: b q_2', of q_2 and der_q_2
Source   Benchmark of two masses and a spring; Wie, Bernstein, J. Guidance 15(5) (1992).
"""

from __future__ import annotations

from typing import Any

from ..framework.arithmetic import Arithmetic
from ..framework.model import InputHold, Model, Slot, SlotFunction, Values, no_effect
from ..framework.variables import choice, declare, input_, parameter, state


class TwoMasses(Model):
    """See the module's text."""

    name = "two_masses"
    description = "Two masses with a coupling, driven at the first one."
    variables = declare(
        parameter("mass_1", 1.0, "kg", "Mass m_1 that is driven", above=0.0),
        parameter("mass_2", 1.0, "kg", "Mass m_2 after the coupling", above=0.0),
        parameter("stiffness", 100.0, "N/m", "Stiffness k of the coupling", minimum=0.0),
        parameter("coupling_damping", 0.1, "N s/m", "Damping c of the coupling", minimum=0.0),
        parameter("damping", 0.0, "N s/m", "Viscous friction b of the second mass", minimum=0.0),
        choice("input_hold", InputHold.interpolate, "What the inputs are during a step"),
        input_("f", "N", "Force on the first mass"),
        state("q_1", "m", "Displacement of the first mass", output=True),
        state("der_q_1", "m/s", "Velocity of the first mass", output=True),
        state("q_2", "m", "Displacement of the second mass", output=True),
        state("der_q_2", "m/s", "Velocity of the second mass", output=True),
    )
    slots = (
        Slot("coupling", "N", "Force of the coupling", {"r": "m", "der_r": "m/s"}),
        Slot("friction", "N", "Friction of the second mass", {"q_2": "m", "der_q_2": "m/s"}),
    )
    input_hold = "input_hold"

    def derivatives(
        self, t: Any, x: Any, u: Any, p: Any, m: Arithmetic, slot: SlotFunction = no_effect
    ) -> Values:
        r = x.q_1 - x.q_2
        der_r = x.der_q_1 - x.der_q_2
        coupling = slot("coupling", p.stiffness * r + p.coupling_damping * der_r, r=r, der_r=der_r)
        friction = slot("friction", p.damping * x.der_q_2, q_2=x.q_2, der_q_2=x.der_q_2)
        return {
            "q_1": x.der_q_1,
            "der_q_1": (u.f - coupling) / p.mass_1,
            "q_2": x.der_q_2,
            "der_q_2": (coupling - friction) / p.mass_2,
        }


MODEL = TwoMasses()

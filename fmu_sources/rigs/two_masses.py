"""
Two masses with an elastic coupling, driven at the first.

    m_1 q_1'' = F - f - d_1 q_1',   m_2 q_2'' = f - d_2 q_2'
    f = k (q_1 - q_2) + c (q_1' - q_2')  (slot `coupling`)

Inputs   force F [N]
Outputs  q_1, q_2 [m], der_q_1, der_q_2 [m/s] (states)   direct feedthrough: none
States   q_1, der_q_1, q_2, der_q_2                       start: 0
Slots    coupling: f, of the twist and its rate
Source   Newton's law.
Limits   Play in the coupling is an effect (`dead_zone`).
"""

from __future__ import annotations

from typing import Any

from ..framework.arithmetic import Arithmetic
from ..framework.model import Model, Slot, SlotFunction, Values, no_effect
from ..framework.variables import declare, input_, parameter, state
from .hold import held, input_hold


class TwoMasses(Model):
    """See the module's text."""

    name = "two_masses"
    description = "Two masses with an elastic coupling."
    variables = declare(
        parameter("mass_1", 10.0, "kg", "Driven mass m_1", above=0.0),
        parameter("mass_2", 5.0, "kg", "Other mass m_2", above=0.0),
        parameter("stiffness", 2e4, "N/m", "Stiffness k of the coupling", above=0.0),
        parameter("damping", 20.0, "N s/m", "Damping c of the coupling", minimum=0.0),
        parameter("damping_1", 5.0, "N s/m", "Damping d_1 to the ground", minimum=0.0),
        parameter("damping_2", 5.0, "N s/m", "Damping d_2 to the ground", minimum=0.0),
        input_("force", "N", "Force F on the first mass"),
        state("q_1", "m", "Position of the first mass", output=True),
        state("der_q_1", "m/s", "Velocity of the first mass", output=True),
        state("q_2", "m", "Position of the second mass", output=True),
        state("der_q_2", "m/s", "Velocity of the second mass", output=True),
        input_hold(),
    )
    slots = (Slot("coupling", "N", "Force of the coupling", {"twist": "m", "der_twist": "m/s"}),)
    delays = held("force")
    input_hold = "input_hold"

    def derivatives(
        self, t: Any, x: Any, u: Any, p: Any, m: Arithmetic, slot: SlotFunction = no_effect
    ) -> Values:
        twist, der_twist = x.q_1 - x.q_2, x.der_q_1 - x.der_q_2
        linear = p.stiffness * twist + p.damping * der_twist
        coupling = slot("coupling", linear, twist=twist, der_twist=der_twist)
        return {
            "q_1": x.der_q_1,
            "der_q_1": (u.force - coupling - p.damping_1 * x.der_q_1) / p.mass_1,
            "q_2": x.der_q_2,
            "der_q_2": (coupling - p.damping_2 * x.der_q_2) / p.mass_2,
        }


MODEL = TwoMasses()

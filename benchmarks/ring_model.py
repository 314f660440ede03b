"""
One link of the ring: a damped mass that follows its neighbour.

    m x'' = k (u - x) - c x'

Inputs   u [m] (place of the neighbour)
Outputs  x [m], v [m/s] (states)        direct feedthrough: none
Source   none: the smallest model that is worth integrating. Overdamped, so that the ring is stable.
"""

from __future__ import annotations

from typing import Any

from fmu_sources.arithmetic import Arithmetic
from fmu_sources.model import Model, SlotFunction, Values, no_effect
from fmu_sources.variables import declare, input_, parameter, state


class Link(Model):
    """See the module's text."""

    name = "link"
    description = "A damped mass that follows its neighbour."
    variables = declare(
        parameter("m", 1.0, "kg", "Mass", above=0.0),
        parameter("c", 200.0, "N s/m", "Damping", minimum=0.0),
        parameter("k", 5000.0, "N/m", "Stiffness", above=0.0),
        input_("u", "m", "Place of the neighbour"),
        state("x", "m", "Place", output=True),
        state("v", "m/s", "Velocity", output=True),
    )

    def derivatives(
        self, t: Any, x: Any, u: Any, p: Any, m: Arithmetic, slot: SlotFunction = no_effect
    ) -> Values:
        return {"x": x.v, "v": (p.k * (u.u - x.x) - p.c * x.v) / p.m}


MODEL = Link()

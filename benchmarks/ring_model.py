"""
One link of the ring: a damped mass that follows its neighbour.

    m x'' = k (mean(u) - x) - c x'

Inputs   u[1..n_inputs] [m] (place of the neighbour, as often as wished)
Outputs  x [m], v [m/s] (states), y[1..n_more] [m] (more signals to record)        direct feedthrough: none
Source   none: the smallest model that is worth integrating. Overdamped, so that the ring is stable.
"""

from __future__ import annotations

from typing import Any

from fmu_sources.framework.arithmetic import Arithmetic
from fmu_sources.framework.model import Model, SlotFunction, Values, no_effect
from fmu_sources.framework.variables import declare, input_, output, parameter, state, vector


class Link(Model):
    """See the module's text."""

    description = "A damped mass that follows its neighbour."

    def __init__(self, n_inputs: int = 1, n_more: int = 0) -> None:
        self.name = f"link_{n_inputs}_{n_more}"
        self.n_inputs, self.n_more = n_inputs, n_more
        self.variables = declare(
            parameter("m", 1.0, "kg", "Mass", above=0.0),
            parameter("c", 200.0, "N s/m", "Damping", minimum=0.0),
            parameter("k", 5000.0, "N/m", "Stiffness", above=0.0),
            vector(input_("u", "m", "Place of the neighbour"), n_inputs),
            state("x", "m", "Place", output=True),
            state("v", "m/s", "Velocity", output=True),
            vector(output("y", "m", "Place seen from a point further on"), n_more),
        )

    def derivatives(
        self, t: Any, x: Any, u: Any, p: Any, m: Arithmetic, slot: SlotFunction = no_effect
    ) -> Values:
        mean = sum(u.u[1:], u.u[0]) / self.n_inputs
        return {"x": x.v, "v": (p.k * (mean - x.x) - p.c * x.v) / p.m}

    def outputs(
        self, t: Any, x: Any, u: Any, p: Any, m: Arithmetic, slot: SlotFunction = no_effect
    ) -> Values:
        return {"y": tuple(x.x - float(i) for i in range(self.n_more))} if self.n_more else {}

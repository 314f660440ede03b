"""A small model with one of everything: every type, both kinds of states, a hidden state, a fault."""

from __future__ import annotations

from collections.abc import Sequence
from enum import IntEnum
from typing import Any

from fmu_sources.framework.arithmetic import Arithmetic
from fmu_sources.framework.model import Fault, InputHold, Model, SlotFunction, Values, no_effect
from fmu_sources.framework.variables import (
    choice,
    declare,
    fixed,
    input_,
    of_each_step,
    output,
    parameter,
    sampled,
    state,
    switch,
    vector,
    whole_number,
)


class Law(IntEnum):
    linear = 1
    soft = 2
    hard = 4


class Specimen(Model):
    """m y'' = u - c y' - law(y) with a sampled mean of u and a counter of samples."""

    name = "specimen"
    description = "One of everything."
    variables = declare(
        parameter("m", 2.0, "kg", "Mass", above=0.0),
        parameter("c", 3.0, "N s/m", "Damping", minimum=0.0, maximum=1e3),
        vector(parameter("k", 400.0, "N/m", "Stiffness, two springs", minimum=0.0), 2),
        switch("spring", True, "Springs act"),
        choice("law", Law.soft, "Spring law"),
        whole_number("n", 3, "Number of equal masses", minimum=1, maximum=9),
        choice("hold", InputHold.interpolate, "Input between the points"),
        fixed(parameter("T", 1e-3, "s", "Sampling period", above=0.0)),
        vector(input_("u", "N", "Forces"), 2),
        state("y", "m", "Displacement", 0.1, output=True),
        state("v", "m/s", "Velocity"),
        of_each_step(state("way", "m", "Way in the step")),
        sampled(state("mean", "N", "Running mean of the first force")),
        sampled(state("count", "1", "Samples"), hidden=True),
        output("f", "N", "Spring force"),
        output("mean_speed", "m/s", "Way in the step over a period"),
        output("stretched", "1", "Displacement is positive", boolean=True),
    )
    sample_time = "T"
    input_hold = "hold"
    fault_texts = (Fault("y", "off the table", "at most 5.0 m"),)

    def initial(self, x: Any, u: Any, p: Any, m: Arithmetic) -> Values:
        return {"mean": u.u[0]}

    def update(self, t: Any, x: Any, u: Any, p: Any, m: Arithmetic, slot: SlotFunction = no_effect) -> Values:
        count = x.count + 1.0
        return {"count": count, "mean": x.mean + (u.u[0] - x.mean) / m.pick((1.0, 2.0, 4.0), count)}

    def derivatives(
        self, t: Any, x: Any, u: Any, p: Any, m: Arithmetic, slot: SlotFunction = no_effect
    ) -> Values:
        force = u.u[0] + u.u[1] * m.sin(7.0 * t) - p.c * x.v - _spring(x.y, p, m)
        return {"y": x.v, "v": force / (p.m * p.n), "way": m.fabs(x.v)}

    def outputs(
        self, t: Any, x: Any, u: Any, p: Any, m: Arithmetic, slot: SlotFunction = no_effect
    ) -> Values:
        return {
            "f": _spring(x.y, p, m),
            "mean_speed": x.way / p.T,
            "stretched": m.where(m.both(x.y > 0.0, p.spring), True, False),
        }

    def faults(self, t: Any, x: Any, u: Any, p: Any, m: Arithmetic) -> Sequence[Any]:
        return (m.fabs(x.y) > 5.0,)


def _spring(y: Any, p: Any, m: Arithmetic) -> Any:
    linear = (p.k[0] + p.k[1]) * y
    soft, hard = m.where(p.law == Law.soft, m.tanh(linear), linear), linear * (1.0 + y * y)
    return m.where(p.spring, m.where(p.law == Law.hard, hard, soft), 0.0)


MODEL = Specimen()

"""
A power of the position: the outflow of a tank (Torricelli, exponent 1/2), a spring of Hertz (3/2).

    F = value + C sign(r) (abs(r) / r_0)^n

Parameters amplitude C [{value}] at r_0, exponent n in 0.05..5, reference r_0 [{position}] > 0 (held in a fit)
Source     Torricelli's law; Wigren, Schoukens, Three free data sets (2013), Cascaded tanks.
Limits     Exponent 1 is a spring.
"""

from __future__ import annotations

from typing import Any

from ..framework.arithmetic import Arithmetic
from ..framework.variables import parameter
from .framework.effect import EVERYWHERE, Applied, Effect
from .framework.experiment import Experiment
from .framework.limit import Limit
from .framework.shapes import larger

SMALLEST = 1e-12


def law(t: Any, value: Any, s: Any, x: Any, p: Any, m: Arithmetic) -> Applied:
    """Add a power of the position."""
    size = m.fabs(s.position) / p.reference
    grown = p.amplitude * m.exp(p.exponent * m.log(larger(size, SMALLEST, m)))
    return Applied(value + m.where(s.position < 0.0, -grown, grown))


EFFECT = Effect(
    name="power_law",
    description="A power of the position",
    law=law,
    parameters=(
        parameter("amplitude", 0.0, "{value}", "Size at the reference C"),
        parameter("exponent", 0.5, "1", "Exponent n", minimum=0.05, maximum=5.0),
        parameter("reference", 1.0, "{position}", "Position r_0 of that size", above=0.0),
    ),
    absent={"amplitude": 0.0},
    scale=lambda rms: {"amplitude": 0.05 * rms.value, "exponent": 0.5, "reference": rms.position},
    needs=("position",),
    places=EVERYWHERE,
    held=("reference",),
    shown_by=(Experiment.WHOLE_RANGE,),
    limits=(
        Limit(
            becomes=None,
            is_reached=lambda p, _: 0.98 < p["exponent"] < 1.02,
            because="in proportion to the position: a spring",
        ),
    ),
)

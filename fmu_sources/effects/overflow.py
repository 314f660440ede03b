"""
An outflow over a weir: nothing up to an edge, then a power 3/2 of what is above.

    F = value + C (max(r - l, 0) / r_0)^(3/2)

Parameters amplitude C [{value}] at r_0 above the edge, edge l, reference r_0 > 0 (held) [{position}]
Source     Poleni's formula of a rectangular weir; Chow, Open-Channel Hydraulics (1959), Sec. 14.
"""

from __future__ import annotations

from typing import Any

from ..framework.arithmetic import Arithmetic
from ..framework.variables import parameter
from .framework.effect import EVERYWHERE, Applied, Effect
from .framework.experiment import Experiment
from .framework.shapes import larger


def law(t: Any, value: Any, s: Any, x: Any, p: Any, m: Arithmetic) -> Applied:
    """Add what flows over the edge."""
    above = larger(s.position - p.edge, 0.0, m) / p.reference
    return Applied(value + p.amplitude * above * m.sqrt(above))


EFFECT = Effect(
    name="overflow",
    description="An outflow over an edge",
    law=law,
    parameters=(
        parameter("amplitude", 0.0, "{value}", "Size at the reference above the edge C"),
        parameter("edge", 0.0, "{position}", "Position of the edge l"),
        parameter("reference", 1.0, "{position}", "Height r_0 of that size", above=0.0),
    ),
    absent={"amplitude": 0.0},
    scale=lambda rms: {"amplitude": 0.05 * rms.value, "edge": rms.position, "reference": rms.position},
    needs=("position",),
    places=EVERYWHERE,
    held=("reference",),
    shown_by=(Experiment.WHOLE_RANGE,),
)

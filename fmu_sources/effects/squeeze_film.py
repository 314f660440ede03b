"""
A squeeze film: damping that grows as a gap closes.

    F = value + c v / left^3,   left = max(1 - side r / g, 1/20)

Parameters coefficient c [{value} s/{position}] >= 0 at r = 0, gap g [{position}] > 0 there, side: the gap
           closes as r grows (+1) or falls (-1)
Source     Reynolds' equation of a film between parallel plates; Hamrock, Fundamentals of Fluid Film
           Lubrication (1994), Sec. 11.
Limits     With a wide gap a damper of c.
"""

from __future__ import annotations

from typing import Any

from ..framework.arithmetic import Arithmetic
from ..framework.variables import parameter
from .framework.effect import MECHANICAL, Applied, Effect
from .framework.experiment import Experiment
from .framework.limit import Limit
from .framework.shapes import larger

SMALLEST_GAP = 0.05


def law(t: Any, value: Any, s: Any, x: Any, p: Any, m: Arithmetic) -> Applied:
    """Add a damper that grows as the gap closes."""
    left = larger(1.0 - p.side * s.position / p.gap, SMALLEST_GAP, m)
    return Applied(value + p.coefficient * s.velocity / (left * left * left))


EFFECT = Effect(
    name="squeeze_film",
    description="Damping that grows as a gap closes",
    law=law,
    parameters=(
        parameter("coefficient", 0.0, "{value} s/{position}", "Damping at rest c", minimum=0.0),
        parameter("gap", 0.01, "{position}", "Gap at rest g", above=0.0),
        parameter("side", 1.0, "1", "The gap closes as r grows (1) or falls (-1)", minimum=-1.0, maximum=1.0),
    ),
    absent={"coefficient": 0.0},
    scale=lambda rms: {"coefficient": 0.05 * rms.value / rms.velocity, "gap": 6.0 * rms.position},
    needs=("position", "velocity"),
    places=MECHANICAL,
    variants=({"side": 1.0}, {"side": -1.0}),
    shown_by=(Experiment.WHOLE_RANGE,),
    limits=(
        Limit(
            becomes=None,
            is_reached=lambda p, rms: p["gap"] > 100.0 * rms.position,
            because="the gap hardly changes: a damper",
        ),
    ),
)

"""
A magnet, or another pull over a gap that closes as the position grows (or falls).

    F = value - side P ((g / (g - side r))^2 - 1)

P is the pull at r = 0, which belongs to the position of rest and is taken off. The gap is kept above a
twentieth of g, for the integrator.

Parameters pull P [{value}], negative for one that repels, gap g [{position}] > 0 at r = 0, side: the gap
           closes as r grows (+1) or falls (-1)
Source     force of an air gap, in proportion to one over its square; Woodson, Melcher, Electromechanical
           Dynamics, Part I (1968), Sec. 3.1.
Limits     With a wide gap a spring of - 2 P / g, which pulls away.
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
    """Add a pull over a gap."""
    left = larger(1.0 - p.side * s.position / p.gap, SMALLEST_GAP, m)
    return Applied(value - p.side * p.pull * (1.0 / (left * left) - 1.0))


EFFECT = Effect(
    name="magnet",
    description="A pull over a gap that closes with the position",
    law=law,
    parameters=(
        parameter("pull", 0.0, "{value}", "Pull at rest P, negative for one that repels"),
        parameter("gap", 0.01, "{position}", "Gap at rest g", above=0.0),
        parameter("side", 1.0, "1", "The gap closes as r grows (1) or falls (-1)", minimum=-1.0, maximum=1.0),
    ),
    absent={"pull": 0.0},
    scale=lambda rms: {"pull": 0.05 * rms.value, "gap": 6.0 * rms.position},
    needs=("position",),
    places=MECHANICAL,
    variants=({"side": 1.0}, {"side": -1.0}),
    shown_by=(Experiment.WHOLE_RANGE,),
    limits=(
        Limit(
            becomes=None,
            is_reached=lambda p, rms: p["gap"] > 60.0 * rms.position,
            because="the gap hardly changes: a spring",
        ),
    ),
)

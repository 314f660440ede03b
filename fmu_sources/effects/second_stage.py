"""
A second stage of stiffness on one side: a spring that is touched beyond a limit, or lost there.

    F = value + side k_2 max(side r - l, 0)

Parameters limit l [{position}] >= 0, stiffness k_2, negative where a part of the spring is lost, side +1, -1
Source     piecewise linear spring; Nayfeh, Mook, Nonlinear Oscillations (1979), Sec. 1.1. Equal stages on
           both sides are `end_stop`.
Limits     No loss of energy where the stage is touched.
"""

from __future__ import annotations

from typing import Any

from ..framework.arithmetic import Arithmetic
from ..framework.variables import parameter
from .framework.effect import MECHANICAL, Applied, Effect
from .framework.experiment import Experiment
from .framework.shapes import larger


def law(t: Any, value: Any, s: Any, x: Any, p: Any, m: Arithmetic) -> Applied:
    """Add a spring beyond a limit on one side."""
    beyond = larger(p.side * s.position - p.limit, 0.0, m)
    return Applied(value + p.side * p.stiffness * beyond)


EFFECT = Effect(
    name="second_stage",
    description="A spring that begins on one side",
    law=law,
    parameters=(
        parameter("limit", 0.0, "{position}", "Elongation l where the stage begins", minimum=0.0),
        parameter("stiffness", 0.0, "{value}/{position}", "Stiffness of the stage k_2"),
        parameter(
            "side", 1.0, "1", "Above the limit (1) or below its negative (-1)", minimum=-1.0, maximum=1.0
        ),
    ),
    absent={"stiffness": 0.0},
    scale=lambda rms: {"limit": rms.position, "stiffness": 0.3 * rms.value / rms.position},
    needs=("position",),
    places=MECHANICAL,
    variants=({"side": 1.0}, {"side": -1.0}),
    shown_by=(Experiment.WHOLE_RANGE,),
)

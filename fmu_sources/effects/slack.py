"""
A rope that carries nothing beyond a limit of its elongation (unilateral).

    F = value (1 - tanh((side r - r_0) / w)) / 2

Parameters limit r_0 [m], side: +1 slack above r_0, -1 slack below -r_0, width w [m] of the change
Source     physics of ropes; the change is rounded over w for the integrator.
Limits     With r_0 other than 0 the force falls from k r_0 to 0 within about 3 w.
"""

from __future__ import annotations

from typing import Any

from ..framework.arithmetic import Arithmetic
from ..framework.variables import parameter
from .framework.common import NEVER
from .framework.effect import MECHANICAL, Applied, Effect
from .framework.experiment import Experiment


def law(t: Any, value: Any, s: Any, x: Any, p: Any, m: Arithmetic) -> Applied:
    """Take the force away on the slack side."""
    return Applied(0.5 * value * (1.0 - m.tanh((p.side * s.position - p.limit) / p.width)))


EFFECT = Effect(
    name="slack",
    description="A rope that carries nothing on one side",
    law=law,
    parameters=(
        parameter("limit", NEVER, "{position}", "Elongation r_0 beyond which the rope is slack"),
        parameter("side", 1.0, "1", "Slack above r_0 (1) or below -r_0 (-1)", minimum=-1.0, maximum=1.0),
        parameter("width", 2e-5, "{position}", "Elongation w over which the force goes", above=0.0),
    ),
    absent={"limit": NEVER},
    scale=lambda rms: {"limit": rms.position, "width": 0.01 * rms.position},
    needs=("position",),
    places=MECHANICAL,
    variants=({"side": 1.0}, {"side": -1.0}),
    shown_by=(Experiment.WHOLE_RANGE,),
)

"""
End stops on both sides.

    F = value + k_s dz(r),   dz(r) = r - clip(r, -l, l)

Parameters limit l [m] >= 0, stiffness k_s [N/m] >= 0
Source     piecewise linear spring; Nayfeh, Mook, Nonlinear Oscillations (1979), Sec. 1.1.
Limits     No loss of energy in the impact.
"""

from __future__ import annotations

from typing import Any

from ..framework.arithmetic import Arithmetic
from ..framework.variables import parameter
from .framework.common import NEVER
from .framework.effect import MECHANICAL, Applied, Effect
from .framework.experiment import Experiment
from .framework.limit import NEGLIGIBLE, Limit
from .framework.shapes import dead_zone


def law(t: Any, value: Any, s: Any, x: Any, p: Any, m: Arithmetic) -> Applied:
    """Add a spring beyond the limits."""
    return Applied(value + p.stiffness * dead_zone(s.position, p.limit, m))


EFFECT = Effect(
    name="end_stop",
    description="Stiff stops on both sides",
    law=law,
    parameters=(
        parameter("limit", NEVER, "{position}", "Free travel on each side l", minimum=0.0),
        parameter("stiffness", 0.0, "{value}/{position}", "Stiffness of the stops k_s", minimum=0.0),
    ),
    absent={"stiffness": 0.0},
    scale=lambda rms: {"limit": 1.2 * rms.position, "stiffness": rms.value / rms.position},
    needs=("position",),
    places=MECHANICAL,
    shown_by=(Experiment.WHOLE_RANGE,),
    limits=(
        Limit(
            becomes=None,
            is_reached=lambda p, rms: p["limit"] < NEGLIGIBLE * rms.position,
            because="the stops touch everywhere: a spring",
        ),
    ),
)

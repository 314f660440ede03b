"""
Clearance: a gap around zero in which a stiffness is missing (backlash, dead band).

    F = value - k_g (r - dz(r)),   dz(r) = r - clip(r, -g, g)

Within the gap the stiffness is smaller by k_g; outside, the force is that of a spring that begins at +-g.
A joint that is free in its gap has k_g equal to the spring's stiffness.

Parameters gap g [m] >= 0 (half of the whole clearance), stiffness k_g [N/m] >= 0
Source     Nordin, Gutman, Automatica 38 (2002) 1633, Eq. 2 (dead-zone model of backlash).
Limits     The spring's damper is not switched off in the gap.
"""

from __future__ import annotations

from typing import Any

from ..framework.arithmetic import Arithmetic
from ..framework.variables import parameter
from .framework.effect import MECHANICAL, Applied, Effect
from .framework.experiment import Experiment
from .framework.limit import Limit
from .framework.shapes import clip


def law(t: Any, value: Any, s: Any, x: Any, p: Any, m: Arithmetic) -> Applied:
    """Take away a stiffness within the gap."""
    return Applied(value - p.stiffness * clip(s.position, -p.gap, p.gap, m))


EFFECT = Effect(
    name="clearance",
    description="A gap around zero in which a stiffness is missing",
    law=law,
    parameters=(
        parameter("gap", 0.0, "{position}", "Half clearance g", minimum=0.0),
        parameter("stiffness", 0.0, "{value}/{position}", "Stiffness that is missing k_g", minimum=0.0),
    ),
    absent={"gap": 0.0},
    scale=lambda rms: {"gap": 0.1 * rms.position, "stiffness": rms.value / rms.position},
    needs=("position",),
    places=MECHANICAL,
    shown_by=(Experiment.WHOLE_RANGE,),
    limits=(
        Limit(
            becomes=None,
            is_reached=lambda p, rms: p["gap"] > 4.0 * rms.position,
            because="the motion stays within the gap: a spring that is softer",
        ),
    ),
)

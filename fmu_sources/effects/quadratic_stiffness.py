"""
Stiffness that grows with elongation in one direction and falls in the other.

    F = value + k_2 r^2

Parameters coefficient k_2 [N/m^2]
Source     Nayfeh, Mook, Nonlinear Oscillations (1979), Sec. 4.1 (quadratic non-linearity).
Limits     k_2 r must stay below the linear stiffness, or the spring pushes the wrong way.
"""

from __future__ import annotations

from typing import Any

from ..framework.arithmetic import Arithmetic
from ..framework.variables import parameter
from .framework.effect import MECHANICAL, Applied, Effect
from .framework.experiment import Experiment


def law(t: Any, value: Any, s: Any, x: Any, p: Any, m: Arithmetic) -> Applied:
    """Add a quadratic spring."""
    return Applied(value + p.coefficient * s.position * s.position)


EFFECT = Effect(
    name="quadratic_stiffness",
    description="Stiffness that differs between pull and push",
    law=law,
    parameters=(parameter("coefficient", 0.0, "{value}/{position}2", "Quadratic stiffness k_2"),),
    absent={"coefficient": 0.0},
    scale=lambda rms: {"coefficient": 0.05 * rms.value / rms.position**2},
    needs=("position",),
    places=MECHANICAL,
    shown_by=(Experiment.WHOLE_RANGE,),
)

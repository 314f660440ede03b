"""
Stiffness that grows (k_3 > 0) or falls (k_3 < 0) with the square of the elongation.

    F = value + k_3 r^3

Parameters coefficient k_3 [N/m^3]
Source     Duffing's spring; Wigren, Schoukens, Three free data sets (2013), Silverbox.
"""

from __future__ import annotations

from typing import Any

from ..framework.arithmetic import Arithmetic
from ..framework.variables import parameter
from .framework.effect import MECHANICAL, Applied, Effect
from .framework.experiment import Experiment


def law(t: Any, value: Any, s: Any, x: Any, p: Any, m: Arithmetic) -> Applied:
    """Add a cubic spring."""
    return Applied(value + p.coefficient * s.position * s.position * s.position)


EFFECT = Effect(
    name="cubic_stiffness",
    description="Hardening or softening, equal in both directions",
    law=law,
    parameters=(parameter("coefficient", 0.0, "{value}/{position}3", "Cubic stiffness k_3"),),
    absent={"coefficient": 0.0},
    scale=lambda rms: {"coefficient": 0.05 * rms.value / rms.position**3},
    needs=("position",),
    places=MECHANICAL,
    shown_by=(Experiment.WHOLE_RANGE,),
)

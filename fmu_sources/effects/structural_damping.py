"""
Structural damping: friction in proportion to the elongation, whatever the speed.

    F = value + s abs(r) tanh(v / v_0)

Parameters coefficient s [{value}/{position}] >= 0, smoothing v_0 [m/s] > 0
Source     loss of a material that does not depend on the frequency; Reid's model, J. R. Aeronaut. Soc. 60
           (1956) 283.
"""

from __future__ import annotations

from typing import Any

from ..framework.arithmetic import Arithmetic
from ..framework.variables import parameter
from .framework.common import SMOOTHING_SHARE, smoothing
from .framework.effect import MECHANICAL, Applied, Effect
from .framework.experiment import Experiment
from .framework.shapes import smooth_sign


def law(t: Any, value: Any, s: Any, x: Any, p: Any, m: Arithmetic) -> Applied:
    """Add friction in proportion to the elongation."""
    size = p.coefficient * m.fabs(s.position)
    return Applied(value + size * smooth_sign(s.velocity, p.smoothing, m))


EFFECT = Effect(
    name="structural_damping",
    description="Friction in proportion to the elongation",
    law=law,
    parameters=(
        parameter("coefficient", 0.0, "{value}/{position}", "Friction per elongation s", minimum=0.0),
        smoothing(),
    ),
    absent={"coefficient": 0.0},
    scale=lambda rms: {
        "coefficient": 0.05 * rms.value / rms.position,
        "smoothing": SMOOTHING_SHARE * rms.velocity,
    },
    needs=("position", "velocity"),
    places=MECHANICAL,
    shown_by=(Experiment.SLOW_REVERSALS,),
)

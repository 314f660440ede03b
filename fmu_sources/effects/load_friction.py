"""
Friction that grows with a load: normal force, band tension or pressure.

    F = value + mu abs(N) tanh(v / v_0)

Parameters coefficient mu [{value}/{load}] >= 0, smoothing v_0 [m/s]
Source     Amontons' law; Armstrong-Helouvry et al., Automatica 30 (1994) 1083, Sec. 2.
Limits     Creeps below v_0 instead of sticking.
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
    """Add friction in proportion to the load."""
    return Applied(value + p.coefficient * m.fabs(s.load) * smooth_sign(s.velocity, p.smoothing, m))


EFFECT = Effect(
    name="load_friction",
    description="Friction in proportion to a load",
    law=law,
    parameters=(
        parameter("coefficient", 0.0, "{value}/{load}", "Friction coefficient mu", minimum=0.0),
        smoothing(),
    ),
    absent={"coefficient": 0.0},
    scale=lambda rms: {
        "coefficient": 0.05 * rms.value / rms.load,
        "smoothing": SMOOTHING_SHARE * rms.velocity,
    },
    needs=("velocity", "load"),
    places=MECHANICAL,
    shown_by=(Experiment.SLOW_REVERSALS,),
)

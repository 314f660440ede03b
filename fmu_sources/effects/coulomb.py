"""
Coulomb friction.

    F = value + F_c tanh(v / v_0)

Parameters level F_c [N] >= 0, smoothing v_0 [m/s]
Source     Armstrong-Helouvry, Dupont, Canudas de Wit, Automatica 30 (1994) 1083, Sec. 2.
Limits     Creeps below v_0 instead of sticking: presliding or Dahl stick.
"""

from __future__ import annotations

from typing import Any

from ..framework.arithmetic import Arithmetic
from .framework.common import SMOOTHING_SHARE, level, smoothing
from .framework.effect import MECHANICAL, Applied, Effect
from .framework.experiment import Experiment
from .framework.limit import Limit
from .framework.shapes import smooth_sign


def law(t: Any, value: Any, s: Any, x: Any, p: Any, m: Arithmetic) -> Applied:
    """Add a force of constant size against the motion."""
    return Applied(value + p.level * smooth_sign(s.velocity, p.smoothing, m))


EFFECT = Effect(
    name="coulomb",
    description="Coulomb friction",
    law=law,
    parameters=(level("Friction force F_c"), smoothing()),
    absent={"level": 0.0},
    scale=lambda rms: {"level": 0.05 * rms.value, "smoothing": SMOOTHING_SHARE * rms.velocity},
    needs=("velocity",),
    places=MECHANICAL,
    shown_by=(
        Experiment.REST_AND_SPEEDS,
        Experiment.SLOW_REVERSALS,
    ),
    limits=(
        Limit(
            becomes=None,
            is_reached=lambda p, rms: p["smoothing"] > 3.0 * rms.velocity,
            because="the sign is rounded over all of the motion: a damper of level / smoothing",
        ),
    ),
)

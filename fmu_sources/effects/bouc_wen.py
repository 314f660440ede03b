"""
Hysteresis of Bouc and Wen, exponent 2.

    F      = value + F_h z
    der(z) = (v - beta abs(v) abs(z) z - (1 - beta) v z^2) / l

Parameters level F_h [N] >= 0, length l [m] > 0, shape beta in 0.5..1 (passive there)
Source     Wen, J. Eng. Mech. 102 (1976) 249, Eq. 2; passivity: Ikhouane, Rodellar (2007), Sec. 2.3.
"""

from __future__ import annotations

from typing import Any

from ..framework.arithmetic import Arithmetic
from ..framework.variables import parameter, state
from .framework.common import level
from .framework.effect import MECHANICAL, Applied, Effect
from .framework.experiment import Experiment
from .framework.limit import NEGLIGIBLE_WAY, Limit


def law(t: Any, value: Any, s: Any, x: Any, p: Any, m: Arithmetic) -> Applied:
    """Add a hysteretic force."""
    z, v = x.share, s.velocity
    der = (v - p.shape * m.fabs(v) * m.fabs(z) * z - (1.0 - p.shape) * v * z * z) / p.length
    return Applied(value + p.level * z, {"share": der})


EFFECT = Effect(
    name="bouc_wen",
    description="Hysteresis with rounded corners",
    law=law,
    parameters=(
        level("Largest hysteretic force F_h"),
        parameter("length", 1e-3, "{position}", "Way over which the force builds up l", above=0.0),
        parameter("shape", 0.5, "1", "Shape of the loop beta", minimum=0.5, maximum=1.0),
    ),
    states=(state("share", "1", "Share of the hysteretic force that has built up z"),),
    absent={"level": 0.0},
    scale=lambda rms: {"level": 0.05 * rms.value, "length": 0.3 * rms.position, "shape": 0.7},
    needs=("position", "velocity"),
    places=MECHANICAL,
    shown_by=(Experiment.SLOW_REVERSALS,),
    limits=(
        Limit(
            becomes="coulomb",
            is_reached=lambda p, rms: p["length"] < NEGLIGIBLE_WAY * rms.position,
            because="the force builds up over next to no way",
            values=lambda p: {"level": p["level"]},
        ),
        Limit(
            becomes=None,
            is_reached=lambda p, rms: p["length"] > 20.0 * rms.position,
            because="the force does not build up within the motion: a spring of level / length",
        ),
    ),
)

"""
Friction that builds up over a short way (Dahl).

    F      = value + F_d z
    der(z) = (v - abs(v) z) / l

Parameters level F_d [N] >= 0, length l [m] > 0: the initial stiffness is F_d / l
Source     Dahl, A solid friction model, TOR-0158(3107-18)-1 (1968), exponent 1.
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
    """Add a friction force with memory of the way."""
    der = (s.velocity - m.fabs(s.velocity) * x.share) / p.length
    return Applied(value + p.level * x.share, {"share": der})


EFFECT = Effect(
    name="dahl",
    description="Friction that builds up over a short way",
    law=law,
    parameters=(
        level("Friction force F_d"),
        parameter("length", 1e-3, "{position}", "Way over which the force builds up l", above=0.0),
    ),
    states=(state("share", "1", "Share of the friction force that has built up z"),),
    absent={"level": 0.0},
    scale=lambda rms: {"level": 0.05 * rms.value, "length": 0.2 * rms.position},
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

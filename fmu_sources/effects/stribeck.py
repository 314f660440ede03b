"""
Coulomb friction that is higher near standstill (Stribeck).

    F = value + (F_c + F_b exp(-(v / v_s)^2)) tanh(v / v_0)

Parameters level F_c [N], breakaway F_b [N], stribeck_velocity v_s [m/s], smoothing v_0 [m/s]
Source     Armstrong-Helouvry et al., Automatica 30 (1994) 1083, Sec. 2.1; exponent 2 after Tustin's form.
Limits     Creeps below v_0 instead of sticking.
"""

from __future__ import annotations

from typing import Any

from ..framework.arithmetic import Arithmetic
from ..framework.variables import parameter
from .framework.common import SMOOTHING_SHARE, level, smoothing
from .framework.effect import MECHANICAL, Applied, Effect
from .framework.experiment import Experiment
from .framework.limit import NEGLIGIBLE, Limit
from .framework.shapes import smooth_sign


def law(t: Any, value: Any, s: Any, x: Any, p: Any, m: Arithmetic) -> Applied:
    """Add a friction force that falls with speed."""
    ratio = s.velocity / p.stribeck_velocity
    size = p.level + p.breakaway * m.exp(-ratio * ratio)
    return Applied(value + size * smooth_sign(s.velocity, p.smoothing, m))


EFFECT = Effect(
    name="stribeck",
    description="Coulomb friction that is higher near standstill",
    law=law,
    parameters=(
        level("Friction force at speed F_c"),
        parameter("breakaway", 0.0, "{value}", "Additional force near standstill F_b", minimum=0.0),
        parameter("stribeck_velocity", 0.01, "{position}/s", "Velocity of the fall v_s", above=0.0),
        smoothing(),
    ),
    absent={"level": 0.0, "breakaway": 0.0},
    scale=lambda rms: {
        "level": 0.05 * rms.value,
        "breakaway": 0.05 * rms.value,
        "stribeck_velocity": 0.3 * rms.velocity,
        "smoothing": SMOOTHING_SHARE * rms.velocity,
    },
    needs=("velocity",),
    places=MECHANICAL,
    shown_by=(Experiment.SLOW_REVERSALS,),
    limits=(
        Limit(
            becomes="coulomb",
            is_reached=lambda p, _: p["breakaway"] < NEGLIGIBLE * p["level"],
            because="next to nothing is added near standstill",
            values=lambda p: {"level": p["level"], "smoothing": p["smoothing"]},
        ),
        Limit(
            becomes="coulomb",
            is_reached=lambda p, rms: p["stribeck_velocity"] < max(0.1 * p["smoothing"], 1e-3 * rms.velocity),
            because="the force falls before the motion has begun",
            values=lambda p: {"level": p["level"], "smoothing": p["smoothing"]},
        ),
        Limit(
            becomes="coulomb",
            is_reached=lambda p, rms: p["stribeck_velocity"] > 10.0 * rms.velocity,
            because="the force does not fall at any speed of the motion",
            values=lambda p: {"level": p["level"] + p["breakaway"], "smoothing": p["smoothing"]},
        ),
    ),
)

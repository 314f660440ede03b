"""
Friction of another size in each direction, dry and viscous.

    F = value + (F_p + F_n)/2 S + (F_p - F_n)/2 S^2 + (abs(d) v where d v > 0),   S = tanh(v / v_0)

S = 1 gives F_p, S = -1 gives -F_n. d > 0 is more damping in forward motion, d < 0 in backward motion.

Parameters forward F_p [N], backward F_n [N] >= 0, damping_difference d [N s/m], smoothing v_0 [m/s]
Source     Janot, Gautier, Brunot, EMPS benchmark (2019), remarks on the axis' asymmetry.
Limits     Creeps below v_0 instead of sticking.
"""

from __future__ import annotations

from typing import Any

from ..framework.arithmetic import Arithmetic
from ..framework.variables import parameter
from .framework.common import SMOOTHING_SHARE, smoothing
from .framework.effect import MECHANICAL, Applied, Effect
from .framework.experiment import Experiment
from .framework.limit import NEGLIGIBLE, Limit
from .framework.shapes import smooth_sign


def law(t: Any, value: Any, s: Any, x: Any, p: Any, m: Arithmetic) -> Applied:
    """Add friction of a size for each direction."""
    sign = smooth_sign(s.velocity, p.smoothing, m)
    dry = 0.5 * (p.forward + p.backward) * sign + 0.5 * (p.forward - p.backward) * sign * sign
    viscous = m.where(p.damping_difference * s.velocity > 0.0, m.fabs(p.damping_difference) * s.velocity, 0.0)
    return Applied(value + dry + viscous)


EFFECT = Effect(
    name="asymmetric_friction",
    description="Friction of another size in each direction",
    law=law,
    parameters=(
        parameter("forward", 0.0, "{value}", "Dry friction in forward motion F_p", minimum=0.0),
        parameter("backward", 0.0, "{value}", "Dry friction in backward motion F_n", minimum=0.0),
        parameter("damping_difference", 0.0, "{value} s/{position}", "Forward minus backward damping d"),
        smoothing(),
    ),
    absent={"forward": 0.0, "backward": 0.0, "damping_difference": 0.0},
    scale=lambda rms: {
        "forward": 0.05 * rms.value,
        "backward": 0.05 * rms.value,
        "damping_difference": 0.05 * rms.value / rms.velocity,
        "smoothing": SMOOTHING_SHARE * rms.velocity,
    },
    needs=("velocity",),
    places=MECHANICAL,
    equals_sum_of=("coulomb", "offset"),
    shown_by=(
        Experiment.REST_AND_SPEEDS,
        Experiment.SLOW_REVERSALS,
    ),
    limits=(
        Limit(
            becomes="coulomb",
            is_reached=lambda p, rms: (
                abs(p["forward"] - p["backward"]) + abs(p["damping_difference"]) * rms.velocity
                < NEGLIGIBLE * (p["forward"] + p["backward"])
            ),
            because="both directions are alike",
            values=lambda p: {"level": 0.5 * (p["forward"] + p["backward"]), "smoothing": p["smoothing"]},
        ),
    ),
)

"""
A spring that relaxes: parallel to the one that is there, a spring in series with a damper (Zener).

    F = value + k_1 z,   z' = v - z / tau

z is the elongation of the spring in series; at the start the arm is at rest.

Parameters stiffness k_1 [{value}/{position}] >= 0, time_constant tau [s] > 0
Source     Zener, Elasticity and Anelasticity of Metals (1948); Maxwell's arm in Wiechert's model.
Limits     With a long time constant a spring of k_1, with a short one a damper of k_1 tau.
"""

from __future__ import annotations

from typing import Any

from ..framework.arithmetic import Arithmetic
from ..framework.variables import parameter, state
from .framework.effect import MECHANICAL, Applied, Effect
from .framework.experiment import Experiment
from .framework.limit import NEGLIGIBLE, Limit


def law(t: Any, value: Any, s: Any, x: Any, p: Any, m: Arithmetic) -> Applied:
    """Add the force of a spring that yields in time."""
    return Applied(
        value + p.stiffness * x.elongation, {"elongation": s.velocity - x.elongation / p.time_constant}
    )


EFFECT = Effect(
    name="relaxation",
    description="A spring that relaxes",
    law=law,
    parameters=(
        parameter("stiffness", 0.0, "{value}/{position}", "Stiffness that relaxes k_1", minimum=0.0),
        parameter("time_constant", 1.0, "s", "Time constant tau", above=0.0),
    ),
    states=(state("elongation", "{position}", "Elongation of the spring in series z"),),
    absent={"stiffness": 0.0},
    scale=lambda rms: {
        "stiffness": 0.1 * rms.value / rms.position,
        "time_constant": rms.position / rms.velocity,
    },
    needs=("position", "velocity"),
    places=MECHANICAL,
    shown_by=(Experiment.LONG_REST,),
    of_class="relaxation",
    limits=(
        Limit(
            becomes=None,
            is_reached=lambda p, rms: p["time_constant"] * rms.velocity < NEGLIGIBLE * rms.position,
            because="the damper yields at once: a damper of stiffness times time constant",
        ),
        Limit(
            becomes=None,
            is_reached=lambda p, rms: NEGLIGIBLE * p["time_constant"] * rms.velocity > rms.position,
            because="nothing yields within the motion: a spring",
        ),
    ),
)

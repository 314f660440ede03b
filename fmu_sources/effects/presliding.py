"""
Dry friction behind a spring (Jenkins element): sticks, yields elastically, then slides.

    F      = value + clip(k z, -F_n, F_p)
    der(z) = v share,   share = clip((z_end - direction z) / w, 0, 1) while z moves outwards, else 1

z is the spring's elongation, z_end = F_p / k forward and F_n / k backward. The integrator needs the corner to
be rounded, over w = z_end / 100 + abs(v) 0.5 ms; clip keeps the force exact where z runs over within a step.
Later effects of the slot see z as position and der(z) as velocity: a clearance then lies in the joint.

Parameters stiffness k [N/m] > 0, forward F_p [N], backward F_n [N] >= 0, start z_0 [m] as the state's start
Source     Jenkins (1962); Iwan, J. Appl. Mech. 33 (1966) 893, Fig. 1.
"""

from __future__ import annotations

from typing import Any

from ..framework.arithmetic import Arithmetic
from ..framework.variables import parameter, state
from .framework.effect import MECHANICAL, Applied, Effect
from .framework.experiment import Experiment
from .framework.limit import NEGLIGIBLE_WAY, Limit
from .framework.shapes import clip

ROUNDING, ROUNDING_TIME = 0.01, 0.5e-3
SMALLEST_TRAVEL = 1e-12


def law(t: Any, value: Any, s: Any, x: Any, p: Any, m: Arithmetic) -> Applied:
    """Add the force of the spring before the slider."""
    forward = s.velocity > 0.0
    end = m.where(forward, p.forward, p.backward) / p.stiffness + SMALLEST_TRAVEL
    left = end - m.where(forward, x.elongation, -x.elongation)
    corner = ROUNDING * end + ROUNDING_TIME * m.fabs(s.velocity)
    der = s.velocity * clip(left / corner, 0.0, 1.0, m)
    force = clip(p.stiffness * x.elongation, -p.backward, p.forward, m)
    signals = {"position": force / p.stiffness, "velocity": der}
    return Applied(value + force, {"elongation": der}, signals)


EFFECT = Effect(
    name="presliding",
    description="Dry friction behind a spring",
    law=law,
    parameters=(
        parameter("stiffness", 1e6, "{value}/{position}", "Stiffness before the slider k", above=0.0),
        parameter("forward", 0.0, "{value}", "Slip force in forward motion F_p", minimum=0.0),
        parameter("backward", 0.0, "{value}", "Slip force in backward motion F_n", minimum=0.0),
    ),
    states=(state("elongation", "{position}", "Elongation of the spring before the slider z"),),
    absent={"forward": 0.0, "backward": 0.0},
    scale=lambda rms: {
        "stiffness": rms.value / (0.2 * rms.position),
        "forward": 0.5 * rms.value,
        "backward": 0.5 * rms.value,
    },
    needs=("position", "velocity"),
    places=MECHANICAL,
    shown_by=(Experiment.SLOW_REVERSALS,),
    limits=(
        Limit(
            becomes="asymmetric_friction",
            is_reached=lambda p, rms: (
                p["forward"] + p["backward"] < NEGLIGIBLE_WAY * p["stiffness"] * rms.position
            ),
            because="it slides after next to no way",
            values=lambda p: {"forward": p["forward"], "backward": p["backward"], "damping_difference": 0.0},
        ),
        Limit(
            becomes=None,
            is_reached=lambda p, rms: min(p["forward"], p["backward"]) > 4.0 * p["stiffness"] * rms.position,
            because="it does not slide within the motion: a spring",
        ),
    ),
)

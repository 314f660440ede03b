"""
Friction of rate and state: grows with speed at once, falls as its contacts are renewed along the way.

    F      = value + (F_0 + a ln(1 + abs(v) / v_r) + b ln(1 + theta v_r / l)) tanh(v / v_0)
    theta' = 1 - abs(v) theta / l

theta [s] is the age of the contacts.

Parameters level F_0, direct a, evolution b [{value}] >= 0, length l [{position}] > 0, reference v_r [m/s] > 0
           (held in a fit), smoothing v_0 [m/s] > 0
Source     Dieterich, J. Geophys. Res. 84 (1979) 2161; Ruina, J. Geophys. Res. 88 (1983) 10359 (ageing).
Limits     Without a and b Coulomb friction.
"""

from __future__ import annotations

from typing import Any

from ..framework.arithmetic import Arithmetic
from ..framework.variables import parameter, state
from .framework.common import SMOOTHING_SHARE, level, smoothing
from .framework.effect import MECHANICAL, Applied, Effect
from .framework.experiment import Experiment
from .framework.limit import NEGLIGIBLE, Limit
from .framework.shapes import larger, smooth_sign


def law(t: Any, value: Any, s: Any, x: Any, p: Any, m: Arithmetic) -> Applied:
    """Add friction of contacts that age and are renewed."""
    speed = m.fabs(s.velocity)
    at_once = p.direct * m.log(1.0 + speed / p.reference)
    aged = p.evolution * m.log(1.0 + larger(x.age, 0.0, m) * p.reference / p.length)
    force = (p.level + at_once + aged) * smooth_sign(s.velocity, p.smoothing, m)
    return Applied(value + force, {"age": 1.0 - speed * x.age / p.length})


EFFECT = Effect(
    name="ageing_contacts",
    description="Friction that depends on speed and on the age of the contacts",
    law=law,
    parameters=(
        level("Friction force F_0"),
        parameter("direct", 0.0, "{value}", "Growth with speed a", minimum=0.0),
        parameter("evolution", 0.0, "{value}", "Growth with age b", minimum=0.0),
        parameter("length", 1e-3, "{position}", "Way that renews the contacts l", above=0.0),
        parameter("reference", 1e-3, "{position}/s", "Reference velocity v_r", above=0.0),
        smoothing(),
    ),
    states=(state("age", "s", "Age of the contacts theta"),),
    absent={"level": 0.0, "direct": 0.0, "evolution": 0.0},
    scale=lambda rms: {
        "level": 0.05 * rms.value,
        "direct": 0.01 * rms.value,
        "evolution": 0.01 * rms.value,
        "length": 0.2 * rms.position,
        "reference": 0.1 * rms.velocity,
        "smoothing": SMOOTHING_SHARE * rms.velocity,
    },
    needs=("position", "velocity"),
    places=MECHANICAL,
    held=("reference",),
    shown_by=(Experiment.SLOW_REVERSALS,),
    limits=(
        Limit(
            becomes="coulomb",
            is_reached=lambda p, _: p["direct"] + p["evolution"] < 0.1 * NEGLIGIBLE * p["level"],
            because="neither speed nor age changes it",
            values=lambda p: {"level": p["level"], "smoothing": p["smoothing"]},
        ),
    ),
)

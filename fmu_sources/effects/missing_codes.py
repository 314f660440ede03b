"""
A converter that loses codes: what is near a multiple of a distance reads as the multiple.

    k = floor(value / D + 1/2),   y = k D where abs(value - k D) < c D / 2, else value

Parameters distance D [{value}] >= 0, share c [1] of the codes that are lost
Source     differential nonlinearity of -1 step; Kester, The Data Conversion Handbook (2005), Sec. 2.3.
Limits     All codes lost but one of each distance are steps of D (`quantisation`); 0 leaves the value.
"""

from __future__ import annotations

from typing import Any

from ..framework.arithmetic import Arithmetic
from ..framework.variables import parameter
from .framework.effect import SIGNAL, Applied, Effect, FirstGuess
from .framework.limit import Limit


def law(t: Any, value: Any, s: Any, x: Any, p: Any, m: Arithmetic) -> Applied:
    """Read values near a multiple as the multiple."""
    is_on = p.distance > 0.0
    distance = m.where(is_on, p.distance, 1.0)
    multiple = distance * m.floor(value / distance + 0.5)
    is_lost = m.both(is_on, m.fabs(value - multiple) < 0.5 * p.share * distance)
    return Applied(m.where(is_lost, multiple, value))


EFFECT = Effect(
    name="missing_codes",
    description="A converter that loses codes",
    law=law,
    parameters=(
        parameter("distance", 0.0, "{value}", "Distance of the codes that are lost D", minimum=0.0),
        parameter("share", 0.0, "1", "Share of the codes that are lost c", minimum=0.0, maximum=1.0),
    ),
    absent={"share": 0.0},
    scale=lambda rms: {"distance": 0.2 * rms.value, "share": 0.2},
    places=SIGNAL,
    first_guess=FirstGuess.QUANTA,
    limits=(
        Limit(
            becomes="quantisation",
            is_reached=lambda p, _: p["share"] > 0.999,
            because="all codes are lost but those at the multiples",
            values=lambda p: {"step": p["distance"]},
        ),
    ),
)

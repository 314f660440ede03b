"""
A value that cannot change faster than a limit.

    z' = R clip(e / (R T), -1, 1),   e = value - z,   y = z + clip(e, -R T, R T),   T = 1 ms

While the value changes slower than R, e stays within R T and y is the value; beyond, y moves with R.

Parameters limit R [{value}/s] > 0
Source     rate limiter; Hess, Snell, J. Guidance Control Dyn. 20 (1997) 90 (a lag
           whose rate is limited).
Limits     A jump of up to R T passes at once.
"""

from __future__ import annotations

from typing import Any

from ..arithmetic import Arithmetic
from ..variables import parameter, state
from .common import NEVER
from .effect import SIGNAL, Applied, Effect
from .shapes import clip

T_FOLLOW = 1e-3


def law(t: Any, value: Any, s: Any, x: Any, p: Any, m: Arithmetic) -> Applied:
    """Limit the rate."""
    near = p.limit * T_FOLLOW
    inside = clip(value - x.followed, -near, near, m)
    far = m.fabs(value - x.followed) > near
    return Applied(m.where(far, x.followed + inside, value), {"followed": inside / T_FOLLOW})


EFFECT = Effect(
    name="rate_saturation",
    description="A value that cannot change faster than a limit",
    law=law,
    parameters=(parameter("limit", NEVER, "{value}/s", "Largest rate R", above=0.0),),
    states=(state("followed", "{value}", "Value that follows z"),),
    absent={"limit": NEVER},
    scale=lambda rms: {"limit": 5.0 * rms.value},
    places=SIGNAL,
    follows=("followed",),
)

"""
A value that cannot change faster than a limit.

    z' = R clip(e / (R tau), -1, 1),   e = value - z,   y = z + clip(e, -R T, R T),   T = 1 ms, tau = T/5

While the value changes slower than R, e stays within R T and y is the value; beyond, y moves with R. So it is
nearly with a value that is held over T: when the next one comes, z is within 6 % of R T of it up to a rate of
0.9 R, within 20 % up to R.

Parameters limit R [{value}/s] > 0
Source     rate limiter; Hess, Snell, J. Guidance Control Dyn. 20 (1997) 90 (a lag
           whose rate is limited).
Limits     A jump of up to R T passes at once.
"""

from __future__ import annotations

from typing import Any

from ..framework.arithmetic import Arithmetic
from ..framework.variables import parameter, state
from .framework.common import NEVER
from .framework.effect import SIGNAL, Applied, Effect
from .framework.experiment import Experiment
from .framework.shapes import clip

T, TAU = 1e-3, 0.2e-3


def law(t: Any, value: Any, s: Any, x: Any, p: Any, m: Arithmetic) -> Applied:
    """Limit the rate."""
    far = value - x.followed
    limited = x.followed + clip(far, -p.limit * T, p.limit * T, m)
    is_fast = m.fabs(far) > p.limit * T
    return Applied(m.where(is_fast, limited, value), {"followed": clip(far / TAU, -p.limit, p.limit, m)})


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
    probe=1.0,
    shown_by=(Experiment.CHIRP,),
    of_class="limit",
)

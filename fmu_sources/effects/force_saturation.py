"""
A value that cannot exceed a limit.

    y = clip(value, -L, L)

Parameters limit L [{value}] >= 0
Source     end of an amplifier's range or of an actuator's force.
"""

from __future__ import annotations

from typing import Any

from ..framework.arithmetic import Arithmetic
from ..framework.variables import parameter
from .framework.common import NEVER
from .framework.effect import Applied, Effect
from .framework.shapes import clip


def law(t: Any, value: Any, s: Any, x: Any, p: Any, m: Arithmetic) -> Applied:
    """Limit the value."""
    return Applied(clip(value, -p.limit, p.limit, m))


EFFECT = Effect(
    name="force_saturation",
    description="A value that cannot exceed a limit",
    law=law,
    parameters=(parameter("limit", NEVER, "{value}", "Largest size L", minimum=0.0),),
    absent={"limit": NEVER},
    scale=lambda rms: {"limit": 1.2 * rms.value},
    probe=1.0,
    of_class="limit",
)

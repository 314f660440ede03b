"""
A value that cannot exceed a limit on one side.

    y = side min(side value, L)

Parameters limit L [{value}], side: an upper limit L (+1) or a lower one -L (-1)
Source     end of an amplifier's range; a valve or a motor that drives in one direction alone.
"""

from __future__ import annotations

from typing import Any

from ..framework.arithmetic import Arithmetic
from ..framework.variables import parameter
from .framework.common import NEVER
from .framework.effect import Applied, Effect


def law(t: Any, value: Any, s: Any, x: Any, p: Any, m: Arithmetic) -> Applied:
    """Limit the value on one side."""
    return Applied(m.where(p.side * value > p.limit, p.side * p.limit, value))


EFFECT = Effect(
    name="one_sided_saturation",
    description="A value that cannot exceed a limit on one side",
    law=law,
    parameters=(
        parameter("limit", NEVER, "{value}", "Limit L"),
        parameter("side", 1.0, "1", "Limit above (1) or below (-1)", minimum=-1.0, maximum=1.0),
    ),
    absent={"limit": NEVER},
    scale=lambda rms: {"limit": 1.2 * rms.value},
    variants=({"side": 1.0}, {"side": -1.0}),
    probe=1.0,
    of_class="limit",
)

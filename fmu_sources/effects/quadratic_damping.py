"""
Damping that grows with the square of speed.

    F = value + c_2 v abs(v)

Parameters coefficient c_2 [N s^2/m^2] >= 0
Source     turbulent flow through an orifice; Merritt, Hydraulic Control Systems (1967), Sec. 3.4.
"""

from __future__ import annotations

from typing import Any

from ..framework.arithmetic import Arithmetic
from ..framework.variables import parameter
from .framework.effect import MECHANICAL, Applied, Effect


def law(t: Any, value: Any, s: Any, x: Any, p: Any, m: Arithmetic) -> Applied:
    """Add a force with the square of speed."""
    return Applied(value + p.coefficient * s.velocity * m.fabs(s.velocity))


EFFECT = Effect(
    name="quadratic_damping",
    description="Damping with the square of speed",
    law=law,
    parameters=(
        parameter("coefficient", 0.0, "{value} s2/{position}2", "Damping coefficient c_2", minimum=0.0),
    ),
    absent={"coefficient": 0.0},
    scale=lambda rms: {"coefficient": 0.05 * rms.value / rms.velocity**2},
    needs=("velocity",),
    places=MECHANICAL,
)

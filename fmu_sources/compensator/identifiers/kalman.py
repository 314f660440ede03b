"""
Kalman filter, the identifier of the paper.

    lambda = 1,   Q and R of the tuning           see `framework/recursion.py` for the recursion

Parameters those of `compensator/tuning.py`
Source     Paper, Sec. IV-B.2, Eqs. 19-21.
"""

from __future__ import annotations

from typing import Any

from ...framework.arithmetic import Arithmetic
from ..tuning import Tuning
from .framework.identifier import Identifier, Vector
from .framework.recursion import Settings


def settings(P: Vector, chosen: Tuning, p: Any, m: Arithmetic) -> Settings:
    """Return the variances of the tuning."""
    return Settings(1.0, chosen.Q_ab, chosen.Q_cde, chosen.R)


IDENTIFIER = Identifier(name="kalman", number=1, held_by="identification_held", settings=settings)

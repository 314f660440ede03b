"""
A constant that is added.

    y = value + b

Parameters offset b
Source     amplifier offset, residue of gravity.
"""

from __future__ import annotations

from typing import Any

from ..framework.arithmetic import Arithmetic
from ..framework.variables import parameter
from .framework.effect import Applied, Effect
from .framework.experiment import Experiment


def law(t: Any, value: Any, s: Any, x: Any, p: Any, m: Arithmetic) -> Applied:
    """Add a constant."""
    return Applied(value + p.offset)


EFFECT = Effect(
    name="offset",
    description="A constant that is added",
    law=law,
    parameters=(parameter("offset", 0.0, "{value}", "Offset b"),),
    absent={"offset": 0.0},
    scale=lambda rms: {"offset": 0.05 * rms.value},
    constant="offset",
    of_class="zero error",
    shown_by=(
        Experiment.REST_AND_SPEEDS,
        Experiment.LONG_REST,
    ),
)

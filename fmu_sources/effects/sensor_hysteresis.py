"""
Hysteresis of a sensor: a share of the reading follows behind a play.

    y = value + c (z - value),   z' = (e - clip(e, -h, h)) / tau,   e = value - z,   tau = 0.2 ms

Parameters share c [1], width h [{value}] >= 0, half of the play
Source     play operator; Krasnosel'skii, Pokrovskii, Systems with Hysteresis (1989), Ch. 2.
Limits     z comes up to tau late.
"""

from __future__ import annotations

from typing import Any

from ..framework.arithmetic import Arithmetic
from ..framework.variables import parameter, state
from .framework.effect import SIGNAL, Applied, Effect
from .framework.experiment import Experiment
from .framework.shapes import dead_zone

TAU = 0.2e-3


def law(t: Any, value: Any, s: Any, x: Any, p: Any, m: Arithmetic) -> Applied:
    """Let a share of the value follow behind a play."""
    behind = x.followed - value
    return Applied(value + p.share * behind, {"followed": -dead_zone(behind, p.width, m) / TAU})


EFFECT = Effect(
    name="sensor_hysteresis",
    description="A reading that depends on where it comes from",
    law=law,
    parameters=(
        parameter("share", 0.0, "1", "Share that follows c", minimum=-2.0, maximum=2.0),
        parameter("width", 0.0, "{value}", "Half of the play h", minimum=0.0),
    ),
    states=(state("followed", "{value}", "Value after the play z"),),
    absent={"share": 0.0},
    scale=lambda rms: {"share": 0.1, "width": 0.3 * rms.value},
    places=SIGNAL,
    follows=("followed",),
    shown_by=(Experiment.SLOW_REVERSALS,),
)

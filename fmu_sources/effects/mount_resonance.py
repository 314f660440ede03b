"""
A resonance of the mount that carries the sensor.

    q'' = w^2 (value - q) - 2 zeta w q',   y = value + share (q - value),   w = 2 pi f

Parameters share [1], frequency f [Hz] > 0, damping zeta [1] > 0
Source     one mode of the frame between sensor and ground; Meirovitch, Fundamentals of Vibrations, Sec. 3.6.
"""

from __future__ import annotations

from typing import Any

from ..framework.arithmetic import Arithmetic
from ..framework.variables import parameter, state
from .framework.effect import SIGNAL, Applied, Effect
from .framework.experiment import Experiment


def law(t: Any, value: Any, s: Any, x: Any, p: Any, m: Arithmetic) -> Applied:
    """Let the value pass a vibrating mount."""
    w = 2.0 * m.pi * p.frequency
    behind = x.carried - value
    changes = {"carried": x.rate, "rate": -w * w * behind - 2.0 * p.damping * w * x.rate}
    return Applied(value + p.share * behind, changes)


EFFECT = Effect(
    name="mount_resonance",
    description="A vibrating mount of the sensor",
    law=law,
    parameters=(
        parameter("share", 0.0, "1", "Share of the value that the mode carries", minimum=-2.0, maximum=2.0),
        parameter("frequency", 25.0, "Hz", "Natural frequency f", above=0.0, maximum=500.0),
        parameter("damping", 0.02, "1", "Damping ratio zeta", above=0.0, maximum=2.0),
    ),
    states=(
        state("carried", "{value}", "Value behind the mount q"),
        state("rate", "{value}/s", "Its rate q'"),
    ),
    absent={"share": 0.0},
    scale=lambda _: {"share": 0.5, "frequency": 25.0, "damping": 0.03},
    places=SIGNAL,
    follows=("carried",),
    acts_like="lag",
    shown_by=(Experiment.CHIRP,),
)

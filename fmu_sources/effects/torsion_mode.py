"""
A mode that an elongation shakes and that pulls back: a rope that twists, a spring that surges.

    F = value + k z,   z' = v - u,   u' = w^2 z - 2 zeta w u,   w = 2 pi f

u is the velocity of the mode, z what it lags; at the start it is at rest.

Parameters stiffness k [{value}/{position}], frequency f [Hz] > 0, damping zeta [1] > 0
Source     one mode coupled to the elongation; Meirovitch, Fundamentals of Vibrations, Sec. 7.
Limits     Far below f a mass of k / w^2, far above a spring of k.
"""

from __future__ import annotations

from typing import Any

from ..framework.arithmetic import Arithmetic
from ..framework.variables import parameter, state
from .framework.effect import MECHANICAL, Applied, Effect
from .framework.experiment import Experiment


def law(t: Any, value: Any, s: Any, x: Any, p: Any, m: Arithmetic) -> Applied:
    """Add the force of a mode."""
    w = 2.0 * m.pi * p.frequency
    changes = {"lag": s.velocity - x.speed, "speed": w * w * x.lag - 2.0 * p.damping * w * x.speed}
    return Applied(value + p.stiffness * x.lag, changes)


EFFECT = Effect(
    name="torsion_mode",
    description="A mode that the elongation shakes",
    law=law,
    parameters=(
        parameter("stiffness", 0.0, "{value}/{position}", "Stiffness of the coupling k"),
        parameter("frequency", 10.0, "Hz", "Natural frequency f", above=0.0, maximum=500.0),
        parameter("damping", 0.02, "1", "Damping ratio zeta", above=0.0, maximum=2.0),
    ),
    states=(
        state("lag", "{position}", "What the mode lags z"),
        state("speed", "{position}/s", "Velocity of the mode u"),
    ),
    absent={"stiffness": 0.0},
    scale=lambda rms: {"stiffness": 0.1 * rms.value / rms.position, "frequency": 10.0, "damping": 0.03},
    needs=("position", "velocity"),
    places=MECHANICAL,
    shown_by=(Experiment.CHIRP,),
    of_class="mode",
)

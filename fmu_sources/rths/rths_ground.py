"""
Ground motion in closed form, in the place of a record: 25 sines that swell, last and fade.

    a_g(t) = amplitude A(t)/PEAK,   A(t) = e(t) sum_{i=0}^{24} sin(2 pi f_i t + i^2)/(1 + ((f_i - 2.5)/2)^2)
    f_i    = 0.4 + 0.37 i Hz
    e(t)   = (t/4)^2 up to 4 s, 1 up to 15 s, exp(-0.3 (t - 15)) after, t in s
    PEAK   = largest |A| at the instants k/4096 s up to 30 s

Inputs   none
Outputs  a_g [m/s2]
States   a_g, at the end of each sampling period   start: the value at the start
Source   The project's own; 0.4 to 9.3 Hz and an envelope as earthquakes have them.
Valid    From t = 0 on.
"""

from __future__ import annotations

from typing import Any

from ..framework.arithmetic import Arithmetic
from ..framework.model import Model, SlotFunction, Values, no_effect
from ..framework.variables import declare, parameter, sampled, state
from .structure import SAMPLE_TIME

N_SINES = 25
PEAK = 4.8190748339394895
"""Largest |A| on the grid of the benchmark."""


class RthsGround(Model):
    """The closed form at the sampling instants."""

    name = "rths_ground"
    description = "Ground motion in closed form for the RTHS benchmark"
    variables = declare(
        parameter("amplitude", 1.25, "m/s2", "Largest acceleration", minimum=0.0),
        SAMPLE_TIME,
        sampled(state("a_g", "m/s2", "Acceleration of the ground", output=True)),
    )
    sample_time = "sample_time"

    def initial(self, x: Any, u: Any, p: Any, m: Arithmetic) -> Values:
        return {"a_g": 0.0}

    def update(self, t: Any, x: Any, u: Any, p: Any, m: Arithmetic, slot: SlotFunction = no_effect) -> Values:
        return {"a_g": p.amplitude / PEAK * shape(t + p.sample_time, m)}


def shape(t: Any, m: Arithmetic) -> Any:
    """Return A(t) [1], t in s."""
    total = 0.0
    for i in range(N_SINES):
        f = 0.4 + 0.37 * i
        total = total + m.sin(2.0 * m.pi * f * t + float(i * i)) / (1.0 + ((f - 2.5) / 2.0) ** 2)
    swelling = t * t / 16.0
    fading = m.exp(-0.3 * (t - 15.0))
    return total * m.where(t < 4.0, swelling, m.where(t < 15.0, 1.0, fading))


MODEL = RthsGround()

"""
Sensors of the rig: displacement transducer and load cell with white noise, quantum and limits.

    x_mea =  limited(rounded(x + sigma_x n_x(k)))       rounded to multiples of quantum_x, within +-limit_x
    f_mea = -limited(rounded(force + sigma_f n_f(k)))   the same with quantum_f, limit_f

The load cell shows the force that moves the specimen; f_mea is the force on the building, hence its sign.

Inputs   x [m], force [N]
Outputs  x_mea [m], f_mea [N]              states; direct feedthrough: none
States   x_mea, f_mea                      start: read from the inputs
         generator_x[1..6], generator_f[1..6] [1]   start: from the seed, the first numbers drawn
Source   Silva et al. (2020), as the other models of this folder: noise powers 6.25e-14 m2 s and 1.16e-3 N2 s,
         times 4096 Hz the variances; converters of 18 bits, +-3.8.
Deviation  The scale of the converters is not published. Quantum and limit of the displacement are taken in
         metres; the force has no quantum, and a limit far above the 8900 N of the actuator, which a perturbed
         plant may reach.
Valid    White noise at the sampling instants, the same whatever the period.
"""

from __future__ import annotations

from typing import Any

from ..force_sensor.noise import N_GENERATOR, normal, seeded
from ..framework.arithmetic import Arithmetic
from ..framework.model import Model, SlotFunction, Values, no_effect
from ..framework.variables import declare, input_, parameter, sampled, state, vector, whole_number
from .structure import SAMPLE_TIME

SECOND_SEED = 1_000_000
"""Added to the seed, for the noise of the force."""


class RthsSensor(Model):
    """Displacement transducer and load cell at the sampling instants."""

    name = "rths_sensor"
    description = "Displacement transducer and load cell of the RTHS benchmark"
    variables = declare(
        parameter("sigma_x", 1.6e-5, "m", "Standard deviation of the noise of the displacement", minimum=0.0),
        parameter("sigma_f", 2.1797981558, "N", "Standard deviation of the noise of the force", minimum=0.0),
        parameter("quantum_x", 2.0**-18, "m", "Quantum of the displacement; 0: none", minimum=0.0),
        parameter("quantum_f", 0.0, "N", "Quantum of the force; 0: none", minimum=0.0),
        parameter("limit_x", 3.8, "m", "Largest displacement that is read", above=0.0),
        parameter("limit_f", 1e5, "N", "Largest force that is read", above=0.0),
        whole_number("seed", 1, "Seed of the noise", minimum=0, maximum=2**31 - 1 - SECOND_SEED),
        SAMPLE_TIME,
        input_("x", "m", "Displacement of the specimen"),
        input_("force", "N", "Force that moves the specimen"),
        sampled(state("x_mea", "m", "Measured displacement", output=True)),
        sampled(state("f_mea", "N", "Measured force on the building", output=True)),
        vector(sampled(state("generator_x", "1", "State of its noise generator"), hidden=True), N_GENERATOR),
        vector(sampled(state("generator_f", "1", "State of its noise generator"), hidden=True), N_GENERATOR),
    )
    sample_time = "sample_time"

    def initial(self, x: Any, u: Any, p: Any, m: Arithmetic) -> Values:
        return _readings(seeded(p.seed, m), seeded(p.seed + SECOND_SEED, m), u, p, m)

    def update(self, t: Any, x: Any, u: Any, p: Any, m: Arithmetic, slot: SlotFunction = no_effect) -> Values:
        return _readings(x.generator_x, x.generator_f, u, p, m)


def _readings(generator_x: Any, generator_f: Any, u: Any, p: Any, m: Arithmetic) -> Values:
    n_x, generator_x = normal(generator_x, m)
    n_f, generator_f = normal(generator_f, m)
    return {
        "x_mea": _converted(u.x + p.sigma_x * n_x, p.quantum_x, p.limit_x, m),
        "f_mea": -_converted(u.force + p.sigma_f * n_f, p.quantum_f, p.limit_f, m),
        "generator_x": generator_x,
        "generator_f": generator_f,
    }


def _converted(value: Any, quantum: Any, limit: Any, m: Arithmetic) -> Any:
    has_quantum = quantum > 0.0
    step = m.where(has_quantum, quantum, 1.0)
    rounded = m.where(has_quantum, step * m.floor(value / step + 0.5), value)
    below = m.where(rounded > limit, limit, rounded)
    return m.where(below < -limit, -limit, below)


MODEL = RthsSensor()

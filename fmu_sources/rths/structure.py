"""
The building of the benchmark, a shear frame of three equal floors: matrices, parameters, states.

    M = m I,   C = 2 zeta sqrt(m) K^(1/2),   damping ratio zeta in each mode
    K = P^-T diag(w^2) P^-1, P the mass-normalised modes, so that P^-T diag(2 zeta w) P^-1 is this C

Source: Silva, Gomez, Maghareh, Dyke, Spencer, Benchmark control problem for real-time hybrid simulation,
Mech. Syst. Signal Process. 135 (2020); the stiffness is that of its code. Cases 1 to 4: m = 1000, 1100,
1300, 1000 kg and zeta = 5, 4, 3, 3 %. Frequencies of case 1: 3.61, 16.00, 38.09 Hz.
"""

from __future__ import annotations

from typing import Any, NamedTuple

from ..framework.arithmetic import Arithmetic
from ..framework.model import Delay, InputHold
from ..framework.variables import choice, declare, fixed, parameter, state

# fmt: off
STIFFNESS = (
    (26054883.87960384, -23133938.8771082, 5937035.46333915),
    (-23133938.8771082, 32560774.18638033, -14419970.77723698),
    (5937035.46333915, -14419970.77723698, 9267275.50622431),
)
"""K [N/m]."""
ROOT_OF_STIFFNESS = (
    (4453.8462299514495, -2489.726529976069, 139.28189216271997),
    (-2489.726529976069, 4725.598116885373, -2007.6748815490698),
    (139.28189216271997, -2007.6748815490698, 2284.1010552812263),
)
"""K^(1/2) [(N/m)^(1/2)], symmetric and positive."""
# fmt: on

WHOLE = declare(
    parameter("floor_mass", 1000.0, "kg", "Mass of each floor", above=0.0),
    parameter("zeta", 0.05, "1", "Damping ratio of each mode", minimum=0.0),
)
SPECIMEN = declare(
    parameter("m_e", 29.13, "kg", "Mass of the specimen", above=0.0),
    parameter("k_e", 1190e3, "N/m", "Stiffness of the specimen", above=0.0),
    parameter("zeta_e", 0.0097, "1", "Damping ratio of the specimen", minimum=0.0),
)
STATES = declare(
    state("x1", "m", "Displacement of floor 1 relative to the ground", output=True),
    state("x2", "m", "Displacement of floor 2 relative to the ground", output=True),
    state("x3", "m", "Displacement of floor 3 relative to the ground", output=True),
    state("v1", "m/s", "Velocity of floor 1 relative to the ground", output=True),
    state("v2", "m/s", "Velocity of floor 2 relative to the ground"),
    state("v3", "m/s", "Velocity of floor 3 relative to the ground"),
)
SAMPLE_TIME = fixed(parameter("sample_time", 1.0 / 4096.0, "s", "Sampling period", above=0.0))
INPUT_HOLD = choice("input_hold", InputHold.interpolate, "Course of a_g during a communication step")
A_G_DELAYS = (
    Delay(
        input="a_g",
        kind="hold",
        by="input_hold",
        steps={"interpolate": 0.0, "hold_new": -0.5, "hold_old": 0.5},
        reason="course within a step",
    ),
)


class Forces(NamedTuple):
    """Forces [N] on the frame at its floors."""

    f1: Any
    f2: Any
    f3: Any


def elastic_forces(x: Any, p: Any, m: Arithmetic) -> Forces:
    """Return C x' + K x of the whole building."""
    damping = 2.0 * p.zeta * m.sqrt(p.floor_mass)
    displacements = (x.x1, x.x2, x.x3)
    velocities = (x.v1, x.v2, x.v3)
    rows = zip(STIFFNESS, ROOT_OF_STIFFNESS, strict=True)
    return Forces(*(_product(k, displacements) + damping * _product(c, velocities) for k, c in rows))


def specimen_damping(p: Any, m: Arithmetic) -> Any:
    """Return c_e [N s/m], which follows the stiffness."""
    return 2.0 * p.zeta_e * m.sqrt(p.m_e * p.k_e)


def _product(row: tuple[float, float, float], vector: tuple[Any, Any, Any]) -> Any:
    return row[0] * vector[0] + row[1] * vector[1] + row[2] * vector[2]

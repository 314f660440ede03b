"""
Servo-hydraulic actuator with the specimen, and the force that moves the specimen.

    q''  = -b_2 q - b_1 q' + a1_b0 (gain s_cmd - x)      servo valve and its displacement loop
    f'   = q - a_3 f - a_2 x'                            force of the actuator
    m_e x'' = f - k_e x - c_e x'                         specimen, c_e = 2 zeta_e sqrt(m_e k_e)
    force = k_e x + c_e v + m_e (v - v_1)/T,   v = (x - x_1)/T,   v_1: of the period before

The command is held over each sampling period T. Nominal poles: 67.1 Hz with a damping ratio of 0.019,
46.9 Hz with 0.62, and -48.2 1/s; x = 1.0075 s_cmd at rest.

Inputs   s_cmd [m]
Outputs  x [m], v [m/s]: the states; force [N]: by backward differences, as the benchmark has it
States   q [N/s], der_q [N/s2], f [N], x [m], v [m/s]     start: 0
         x_1 [m], v_1 [m/s]                               start: 0
Source   Silva et al. (2020), as `rths_building`; the values of its code, which Table 2 rounds;
         standard deviations of the perturbed plants k_e 50e3, b_1 3.3, b_2 3.3e3, a_3 1.3.
Valid    Linear: no limit of valve or force.
"""

from __future__ import annotations

from typing import Any

from ..framework.arithmetic import Arithmetic
from ..framework.model import Delay, Model, SlotFunction, Values, no_effect
from ..framework.variables import declare, input_, output, parameter, sampled, state
from .structure import SAMPLE_TIME, SPECIMEN, specimen_damping


class RthsActuator(Model):
    """Five continuous states, and two sampled ones of the force."""

    name = "rths_actuator"
    description = "Servo-hydraulic actuator with the specimen of the RTHS benchmark"
    variables = declare(
        parameter("a1_b0", 2.1283e13, "N/(m.s3)", "Gain of valve and displacement loop", above=0.0),
        parameter("gain", 1.0261, "1", "Gain of the command", above=0.0),
        parameter("a_2", 4.2297e6, "N/m", "Force of the velocity, by the compressed oil", minimum=0.0),
        parameter("a_3", 3.3, "1/s", "Leakage"),
        parameter("b_1", 425.0, "1/s", "Damping of the servo valve", minimum=0.0),
        parameter("b_2", 9.9976e4, "1/s2", "Stiffness of the servo valve", above=0.0),
        SPECIMEN,
        SAMPLE_TIME,
        input_("s_cmd", "m", "Commanded displacement"),
        state("q", "N/s", "Rate of the force that the servo valve asks for"),
        state("der_q", "N/s2", "Its rate"),
        state("f", "N", "Force of the actuator"),
        state("x", "m", "Displacement of the specimen", output=True),
        state("v", "m/s", "Velocity of the specimen", output=True),
        sampled(state("x_1", "m", "Displacement, a period before"), hidden=True),
        sampled(state("v_1", "m/s", "Difference quotient, a period before"), hidden=True),
        output("force", "N", "Force that moves the specimen"),
    )
    delays = (
        Delay(
            input="s_cmd",
            kind="hold",
            steps=-0.5,
            reason="the command set before the step is held over the step",
        ),
    )
    sample_time = "sample_time"
    substep = 6.2e-5

    def update(self, t: Any, x: Any, u: Any, p: Any, m: Arithmetic, slot: SlotFunction = no_effect) -> Values:
        return {"x_1": x.x, "v_1": (x.x - x.x_1) / p.sample_time}

    def derivatives(
        self, t: Any, x: Any, u: Any, p: Any, m: Arithmetic, slot: SlotFunction = no_effect
    ) -> Values:
        c_e = specimen_damping(p, m)
        return {
            "q": x.der_q,
            "der_q": -p.b_2 * x.q - p.b_1 * x.der_q + p.a1_b0 * (p.gain * u.s_cmd - x.x),
            "f": x.q - p.a_3 * x.f - p.a_2 * x.v,
            "x": x.v,
            "v": (x.f - p.k_e * x.x - c_e * x.v) / p.m_e,
        }

    def outputs(
        self, t: Any, x: Any, u: Any, p: Any, m: Arithmetic, slot: SlotFunction = no_effect
    ) -> Values:
        T = p.sample_time
        v = (x.x - x.x_1) / T
        return {"force": p.k_e * x.x + specimen_damping(p, m) * v + p.m_e * (v - x.v_1) / T}


MODEL = RthsActuator()

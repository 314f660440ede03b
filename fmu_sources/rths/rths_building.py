"""
The building without the specimen: the numerical part of the hybrid test.

    M_n x'' + C_n x' + K_n x = -m 1 a_g + e_1 f_e,   e_1 = (1, 0, 0)
    M_n = m I - e_1 e_1' m_e,   C_n = C - e_1 e_1' c_e,   K_n = K - e_1 e_1' k_e

so that with f_e = -(m_e x_1'' + c_e x_1' + k_e x_1) it is the whole building. The force is sampled and held
over each period, the ground motion lies on a straight line from its previous value to the new one.

Inputs   a_g [m/s2], f_e [N]: force of the specimen on floor 1
Outputs  x1, x2, x3 [m], v1 [m/s], a1 [m/s2]    a1 with the force of the last period
States   x1, x2, x3 [m], v1, v2, v3 [m/s]       start: 0, settable
         f_held [N]                             start: f_e
Source   Silva, Gomez, Maghareh, Dyke, Spencer, Benchmark control problem for real-time hybrid simulation,
         Mech. Syst. Signal Process. 135 (2020); K and C as `structure.py` has them.
Valid    As `rths_reference`; m_e, k_e, zeta_e are those of the specimen that is taken out.
"""

from __future__ import annotations

from typing import Any

from ..framework.arithmetic import Arithmetic
from ..framework.model import Delay, Model, SlotFunction, Values, no_effect
from ..framework.variables import declare, input_, output, sampled, state
from .structure import (
    A_G_DELAYS,
    INPUT_HOLD,
    SAMPLE_TIME,
    SPECIMEN,
    STATES,
    WHOLE,
    elastic_forces,
    specimen_damping,
)


class RthsBuilding(Model):
    """Building less specimen."""

    name = "rths_building"
    description = "Numerical part of the building of the RTHS benchmark"
    variables = declare(
        WHOLE,
        SPECIMEN,
        INPUT_HOLD,
        SAMPLE_TIME,
        input_("a_g", "m/s2", "Acceleration of the ground"),
        input_("f_e", "N", "Force of the specimen on floor 1"),
        STATES,
        sampled(state("f_held", "N", "Force of the specimen in this period"), hidden=True),
        output("a1", "m/s2", "Acceleration of floor 1 relative to the ground"),
    )
    delays = (
        *A_G_DELAYS,
        Delay(
            input="f_e",
            kind="hold",
            steps=-0.5,
            reason="the force set before the step is held over the step",
        ),
    )
    sample_time = "sample_time"
    input_hold = "input_hold"

    def initial(self, x: Any, u: Any, p: Any, m: Arithmetic) -> Values:
        return {"f_held": u.f_e}

    def update(self, t: Any, x: Any, u: Any, p: Any, m: Arithmetic, slot: SlotFunction = no_effect) -> Values:
        return {"f_held": u.f_e}

    def derivatives(
        self, t: Any, x: Any, u: Any, p: Any, m: Arithmetic, slot: SlotFunction = no_effect
    ) -> Values:
        a1, a2, a3 = _accelerations(x, u, p, m)
        return {"x1": x.v1, "x2": x.v2, "x3": x.v3, "v1": a1, "v2": a2, "v3": a3}

    def outputs(
        self, t: Any, x: Any, u: Any, p: Any, m: Arithmetic, slot: SlotFunction = no_effect
    ) -> Values:
        a1, _, _ = _accelerations(x, u, p, m)
        return {"a1": a1}


def _accelerations(x: Any, u: Any, p: Any, m: Arithmetic) -> tuple[Any, Any, Any]:
    m_f = p.floor_mass
    f1, f2, f3 = elastic_forces(x, p, m)
    of_specimen = specimen_damping(p, m) * x.v1 + p.k_e * x.x1
    a1 = (-m_f * u.a_g - f1 + of_specimen + x.f_held) / (m_f - p.m_e)
    return a1, -u.a_g - f2 / m_f, -u.a_g - f3 / m_f


MODEL = RthsBuilding()

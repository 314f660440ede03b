"""
The undivided building under the same ground motion: what a hybrid test is judged by.

    m x'' + C x' + K x = -m 1 a_g         shear frame of three floors, x relative to the ground

Inputs   a_g [m/s2], on a straight line from the previous value to the new one
Outputs  x1, x2, x3 [m], v1 [m/s]
States   x1, x2, x3 [m], v1, v2, v3 [m/s]     start: 0, settable
Source   Silva et al. (2020); K and C as `structure.py` has them.
Valid    Linear, one direction, equal floors.
"""

from __future__ import annotations

from typing import Any

from ..framework.arithmetic import Arithmetic
from ..framework.model import Model, SlotFunction, Values, no_effect
from ..framework.variables import declare, input_
from .structure import A_G_DELAYS, INPUT_HOLD, STATES, WHOLE, elastic_forces


class RthsReference(Model):
    """Whole building, nothing on a rig."""

    name = "rths_reference"
    description = "Undivided building of the RTHS benchmark"
    variables = declare(
        WHOLE,
        INPUT_HOLD,
        input_("a_g", "m/s2", "Acceleration of the ground"),
        STATES,
    )
    delays = A_G_DELAYS
    input_hold = "input_hold"

    def derivatives(
        self, t: Any, x: Any, u: Any, p: Any, m: Arithmetic, slot: SlotFunction = no_effect
    ) -> Values:
        f1, f2, f3 = elastic_forces(x, p, m)
        m_f = p.floor_mass
        return {
            **{"x1": x.v1, "x2": x.v2, "x3": x.v3},
            **{"v1": -u.a_g - f1 / m_f, "v2": -u.a_g - f2 / m_f, "v3": -u.a_g - f3 / m_f},
        }


MODEL = RthsReference()

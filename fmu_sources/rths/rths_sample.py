"""
The sample controller of the benchmark: a lead on the target and a PI controller of the displacement.

    y     = lead(s_des),   lead(s) = (lead_gain s + lead_pole)/(s + lead_pole)
    s_cmd = P e + I int(e),   e = y - s_act          both after the rule of Tustin
    f_comp = f_mea

Inputs   s_des, s_act, x [m], f_mea [N], v_des [m/s], a_des [m/s2]      used: s_des, s_act, f_mea
Outputs  f_comp [N], s_cmd [m]
States   f_comp, s_cmd, integral [m s], last_e, last_s_des, last_y [m]    start: steady in the inputs
Source   Silva et al. (2020), as `rths_building`: the controller that comes with the benchmark's code.
Valid    The actuator of the benchmark, for which it is tuned.
"""

from __future__ import annotations

from typing import Any

from ..compensators.plugs import INPUTS, OUTPUTS, TERMINALS
from ..framework.arithmetic import Arithmetic
from ..framework.model import Model, SlotFunction, Values, no_effect
from ..framework.variables import declare, parameter, sampled, state
from .structure import SAMPLE_TIME


class RthsSample(Model):
    """Displacement method: lead and PI controller."""

    name = "rths_sample"
    description = "Sample controller of the RTHS benchmark, lead and PI"
    variables = declare(
        parameter("P", 2.0, "1", "Proportional gain"),
        parameter("I", 95.0, "1/s", "Integral gain", above=0.0),
        parameter("lead_gain", 50.8316, "1", "Gain of the lead far above its pole"),
        parameter("lead_pole", 8570.397, "1/s", "Pole of the lead", above=0.0),
        SAMPLE_TIME,
        INPUTS,
        OUTPUTS,
        sampled(state("integral", "m.s", "Integral of the error"), hidden=True),
        sampled(state("last_e", "m", "Error, k-1"), hidden=True),
        sampled(state("last_s_des", "m", "Target, k-1"), hidden=True),
        sampled(state("last_y", "m", "Target after the lead, k-1"), hidden=True),
    )
    terminals = TERMINALS
    sample_time = "sample_time"

    def initial(self, x: Any, u: Any, p: Any, m: Arithmetic) -> Values:
        return {
            **{"f_comp": u.f_mea, "s_cmd": u.s_des, "integral": u.s_des / p.I},
            **{"last_e": 0.0, "last_s_des": u.s_des, "last_y": u.s_des},
        }

    def update(self, t: Any, x: Any, u: Any, p: Any, m: Arithmetic, slot: SlotFunction = no_effect) -> Values:
        T = p.sample_time
        w = 2.0 / T
        now = (p.lead_gain * w + p.lead_pole) * u.s_des
        before = (p.lead_gain * w - p.lead_pole) * x.last_s_des
        y = (now - before + (w - p.lead_pole) * x.last_y) / (w + p.lead_pole)
        e = y - u.s_act
        integral = x.integral + 0.5 * T * (e + x.last_e)
        return {
            **{"f_comp": u.f_mea, "s_cmd": p.P * e + p.I * integral, "integral": integral},
            **{"last_e": e, "last_s_des": u.s_des, "last_y": y},
        }


MODEL = RthsSample()

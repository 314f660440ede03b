"""
Prismatic axis with motor and PD cascade in closed loop (EMPS).

    M q''   = g_tau v - F,   F = c q'  (slot `friction`)
    v(k)    = clip(k_v (k_p (q_ref(k) - q(k)) - q'_est(k)), -v_max, v_max) + pulse(k)
    q'_est  = (q(k) - q(k-2)) / (2 T)        backward difference of a mean of two samples

Inputs   q_ref [m], pulse [V]            held over a sampling period
Outputs  q [m], der_q [m/s], v [V], force [N] = g_tau v     direct feedthrough: none to q
States   q, der_q; sampled: v, q(k-1), q(k-2)   start: 0
Slots    friction: c q', of q and der_q
Source   Janot, Gautier, Brunot, Data Set and Reference Models of EMPS, Workshop on Nonlinear System
         Identification Benchmarks 2019. The estimate of the velocity is found from the data: with it the
         recorded v is met within 3.7 mV rms (4.7 mV with pulses of gain 1.014), with others not below 36 mV.
Deviation  Dry friction and offset of the amplifier are effects here (`coulomb`, `offset`).
"""

from __future__ import annotations

from typing import Any

from ..effects.framework.shapes import clip
from ..framework.arithmetic import Arithmetic
from ..framework.model import Model, Slot, SlotFunction, Values, no_effect
from ..framework.variables import declare, fixed, input_, output, parameter, sampled, state


class ServoAxis(Model):
    """See the module's text."""

    name = "servo_axis"
    description = "Prismatic axis with motor and PD cascade in closed loop."
    variables = declare(
        parameter("mass", 95.1, "kg", "Moving mass M", above=0.0),
        parameter("damping", 203.5, "N s/m", "Viscous friction c", minimum=0.0),
        parameter("drive_gain", 35.15065188248547, "N/V", "Force per volt g_tau", above=0.0),
        parameter("position_gain", 160.18, "1/s", "Position gain k_p", minimum=0.0),
        parameter("velocity_gain", 243.45, "V s/m", "Velocity gain k_v", minimum=0.0),
        parameter("largest_voltage", 10.0, "V", "Saturation v_max", above=0.0),
        fixed(parameter("sampling_period", 1e-3, "s", "Sampling period T", above=0.0)),
        input_("q_ref", "m", "Reference position"),
        input_("pulse", "V", "Voltage that is added"),
        state("q", "m", "Position", output=True),
        state("der_q", "m/s", "Velocity", output=True),
        sampled(state("v", "V", "Voltage of the drive", output=True)),
        sampled(state("last_q", "m", "Position one period ago"), hidden=True),
        sampled(state("second_last_q", "m", "Position two periods ago"), hidden=True),
        output("force", "N", "Force of the drive"),
    )
    slots = (Slot("friction", "N", "Friction of the axis", {"q": "m", "der_q": "m/s"}),)
    sample_time = "sampling_period"

    def initial(self, x: Any, u: Any, p: Any, m: Arithmetic) -> Values:
        return {"last_q": x.q, "second_last_q": x.q - p.sampling_period * x.der_q}

    def update(self, t: Any, x: Any, u: Any, p: Any, m: Arithmetic, slot: SlotFunction = no_effect) -> Values:
        estimate = (x.q - x.second_last_q) / (2.0 * p.sampling_period)
        command = p.velocity_gain * (p.position_gain * (u.q_ref - x.q) - estimate)
        v = clip(command, -p.largest_voltage, p.largest_voltage, m) + u.pulse
        return {"v": v, "last_q": x.q, "second_last_q": x.last_q}

    def derivatives(
        self, t: Any, x: Any, u: Any, p: Any, m: Arithmetic, slot: SlotFunction = no_effect
    ) -> Values:
        friction = slot("friction", p.damping * x.der_q, q=x.q, der_q=x.der_q)
        return {"q": x.der_q, "der_q": (p.drive_gain * x.v - friction) / p.mass}

    def outputs(
        self, t: Any, x: Any, u: Any, p: Any, m: Arithmetic, slot: SlotFunction = no_effect
    ) -> Values:
        return {"force": p.drive_gain * x.v}


MODEL = ServoAxis()

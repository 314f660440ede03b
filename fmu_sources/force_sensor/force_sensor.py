"""
Force sensor: lag of first order, zero offset, white Gaussian noise.

    T_f f_lag' + f_lag = f_act,   S(s) = 1/(1 + T_f s)                                           (4)
    f_mea  = f_lag + offset + sigma n(k)                                                         (25)

Exact over one sampling period T for an f_act that is linear from the previous to the present value
(first-order hold), q = exp(-T/T_f):

    f_lag(k+1) = q f_lag(k) + (T_f/T (1 - q) - q) f_act(k) + (1 - T_f/T (1 - q)) f_act(k+1)

Inputs   f_act [N]
Outputs  f_mea [N]                       direct feedthrough: none
States   f_lag [N], last_f_act [N]       start: f_act
         noise [1], generator[1..6] [1]  start: from the seed, the first number drawn
Source   Paper, Sec. III-B, Eq. 4, and Sec. V-A, Eq. 25. R_k = 0.001 is a variance: sigma 0.0316 N.
Deviation  The paper has either the lag (experiment) or the noise (simulation); here both.
Valid    One axis; no saturation, no quantisation, no cross-talk. T_f = 0 passes f_act through.
"""

from __future__ import annotations

from typing import Any

from ..framework.arithmetic import Arithmetic
from ..framework.model import Delay, Model, Slot, SlotFunction, Values, no_effect
from ..framework.variables import (
    declare,
    fixed,
    input_,
    output,
    parameter,
    sampled,
    state,
    vector,
    whole_number,
)
from .noise import N_GENERATOR, normal, seeded


class ForceSensor(Model):
    """Eqs. 4 and 25 at the sampling instants."""

    name = "force_sensor"
    description = "Force sensor with lag, zero offset and reproducible white noise"
    variables = declare(
        parameter("T_f", 0.01, "s", "Time constant of the lag", minimum=0.0),
        parameter("sigma", 0.0316, "N", "Standard deviation of the white noise", minimum=0.0),
        parameter("offset", 0.0, "N", "Zero offset"),
        whole_number("seed", 1, "Seed of the noise", minimum=0, maximum=2**31 - 1),
        fixed(parameter("sample_time", 1e-3, "s", "Sampling period", above=0.0)),
        input_("f_act", "N", "Actual contact force"),
        sampled(state("f_lag", "N", "Force after the lag")),
        sampled(state("last_f_act", "N", "Actual force at the last sampling instant"), hidden=True),
        sampled(state("noise", "1", "Noise of variance 1"), hidden=True),
        vector(sampled(state("generator", "1", "State of the noise generator"), hidden=True), N_GENERATOR),
        output("f_mea", "N", "Measured contact force"),
    )
    slots = (Slot("output", "N", "Measured force with offset and noise", {"f_act": "N", "f_lag": "N"}),)
    delays = (Delay(input="f_act", kind="lag", seconds="T_f", reason="lag of Eq. 4"),)
    sample_time = "sample_time"

    def initial(self, x: Any, u: Any, p: Any, m: Arithmetic) -> Values:
        noise, generator = normal(seeded(p.seed, m), m)
        return {"f_lag": u.f_act, "last_f_act": u.f_act, "noise": noise, "generator": generator}

    def update(self, t: Any, x: Any, u: Any, p: Any, m: Arithmetic, slot: SlotFunction = no_effect) -> Values:
        T = p.sample_time
        has_lag = p.T_f > 0.0
        q = m.where(has_lag, m.exp(-T / m.where(has_lag, p.T_f, T)), 0.0)
        mean = p.T_f / T * (1.0 - q)
        f_lag = q * x.f_lag + (mean - q) * x.last_f_act + (1.0 - mean) * u.f_act
        noise, generator = normal(x.generator, m)
        return {"f_lag": f_lag, "last_f_act": u.f_act, "noise": noise, "generator": generator}

    def outputs(
        self, t: Any, x: Any, u: Any, p: Any, m: Arithmetic, slot: SlotFunction = no_effect
    ) -> Values:
        f = x.f_lag + p.offset + p.sigma * x.noise
        return {"f_mea": slot("output", f, f_act=u.f_act, f_lag=x.f_lag)}


MODEL = ForceSensor()

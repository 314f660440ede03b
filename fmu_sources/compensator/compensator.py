"""
Force and displacement compensation towards divergence and accuracy, in the order of one period k.

    f_lead(k) = (1 + T_f_hat s) f_mea                        FMDC, `force_lead`                  (14)
    f(k)      = a f(k-1) + b f(k-2) - c s(k) - d s(k-1) - e s(k-2),   s = s_act - x              (15)
    Y         = (a, b, c, d, e)                              `kalman` or `rls`, f = f_lead       (19-21)
    dF(k)     = a dF(k-1) + b dF(k-2) - c ds(k) - d ds(k-1) - e ds(k-2),   ds = s_des - s_act    (17)
    f_des(k)  = f_lead(k) + dF(k)                            CFDC, `contact_force`               (18)
    s_cmd(k)  = K (1 + alpha T_lead s)/(1 + T_lead s) s_des  DPDC, `phase_lead`                  (22)

A part that is switched off passes its input on, and the correction is 0.

Inputs   s_des [m], s_act [m], f_mea [N], x [m]; not used: v_des [m/s] and a_des [m/s2], plugs of all methods
Outputs  f_des [N], f_comp the same, s_cmd [m], df [N], f_lead [N], a, b [1], c, d, e [N/m],
         m_e_id [kg], k_m_id, k_p_id [N/m], c_m_id, c_p_id [N s/m], attributes_valid
States   all sampled: Y from the assumed attribute parameters (c, d, e times prior_gain for kalman, rls),
         dF = 0, the leads and all histories steady in the inputs at the start
Source   Paper, Sec. IV, Eqs. 14-24.
Deviation  c, d, e stand for -s (restoring force); the force of Eq. 15 is the one after FMDC, not after CFDC;
           K has a factor of its own, dpdc_gain, 1 in the paper; P + Q before the gain in Eq. 21; prefilter,
           identifier fixed, identification_held, unit_dc and fmdc_filter are additions.
Valid    Linear contact. Singly the parameters are not identifiable from one oscillation, only G at its
         frequency is.
"""

from __future__ import annotations

from typing import Any

from ..framework.arithmetic import Arithmetic
from ..framework.model import Delay, Model, Slot, SlotFunction, Terminal, Values, no_effect
from ..framework.variables import declare
from .contact_force import correction
from .difference import attributes, process_parameters, weight
from .force_lead import lead
from .identification import LEARNING, LINEAR, identified, prior_gain
from .identifiers.framework.recursion import diagonal
from .phase_lead import command, design
from .ports import INPUTS, MEMORY, OUTPUTS, PARAMETERS, PROCESS, SWITCHES
from .tuning import tuning


class Compensator(Model):
    """Eqs. 14-24 at the sampling instants."""

    name = "compensator"
    description = "Force and displacement compensation: FMDC, CFDC with identification, DPDC"
    variables = declare(SWITCHES, PARAMETERS, INPUTS, PROCESS, MEMORY, OUTPUTS)
    slots = (
        Slot("force_correction", "N", "Contact force correction", {"ds": "m", "f_lead": "N"}),
        Slot("command", "m", "Command to the motion simulator", {"s_des": "m"}),
    )
    terminals = (
        Terminal(
            "spacecraft",
            "dynamics",
            "Plug of the dynamics model",
            {"force": "f_des", "displacement": "s_des"},
        ),
        Terminal(
            "motion_simulator",
            "motion",
            "Plug of the motion simulator",
            {"command": "s_cmd", "displacement": "s_act"},
        ),
        Terminal(
            "docking",
            "contact",
            "Plug of the measured docking mechanism",
            {"force": "f_mea", "travel": "x"},
        ),
    )
    delays = (
        Delay(input="f_mea", kind="lag", seconds="fmdc_filter", reason="filter pole of the force lead"),
    )
    linear = LINEAR
    learning = LEARNING
    sample_time = "sample_time"

    def initial(self, x: Any, u: Any, p: Any, m: Arithmetic) -> Values:
        chosen = tuning(p, m)
        gain = prior_gain(p, m)
        a, b, c, d, e = process_parameters(p, weight(p.difference_method, m))
        f, s, ds = u.f_mea, u.s_act - u.x, u.s_des - u.s_act
        return {
            **{"a": a, "b": b, "c": gain * c, "d": gain * d, "e": gain * e},
            "P": diagonal(chosen.P0_ab, chosen.P0_cde),
            **dict.fromkeys(("f_lead", "last_f_mea", "f_stage", "f_1", "f_2"), f),
            **dict.fromkeys(("s_stage", "s_1", "s_2"), s),
            **{"dF_1": 0.0, "dF_2": 0.0, "ds_1": ds, "ds_2": ds},
            **{"last_s_des": u.s_des, "led_command": design(p, m).K * u.s_des},
        }

    def update(self, t: Any, x: Any, u: Any, p: Any, m: Arithmetic, slot: SlotFunction = no_effect) -> Values:
        f_lead = m.where(p.fmdc, lead(x.f_lead, x.last_f_mea, u.f_mea, p), u.f_mea)
        Y, memory = identified(f_lead, u.s_act - u.x, x, p, m)
        ds = u.s_des - u.s_act
        dF = correction(Y, (x.dF_1, x.dF_2), (ds, x.ds_1, x.ds_2))
        led = command(design(p, m), x.led_command, x.last_s_des, u.s_des, p.sample_time)
        return {
            **dict(zip("abcde", Y, strict=True)),
            **memory,
            **{"f_lead": f_lead, "last_f_mea": u.f_mea},
            **{"dF_1": m.where(p.cfdc, dF, 0.0), "dF_2": x.dF_1, "ds_1": ds, "ds_2": x.ds_1},
            **{"last_s_des": u.s_des, "led_command": led},
        }

    def outputs(
        self, t: Any, x: Any, u: Any, p: Any, m: Arithmetic, slot: SlotFunction = no_effect
    ) -> Values:
        df = slot("force_correction", x.dF_1, ds=x.ds_1, f_lead=x.f_lead)
        s_cmd = slot("command", m.where(p.dpdc, x.led_command, x.last_s_des), s_des=x.last_s_des)
        found = attributes((x.a, x.b, x.c, x.d, x.e), weight(p.difference_method, m), p, m)
        f_des = x.f_lead + df
        return {
            **{"f_des": f_des, "f_comp": f_des, "s_cmd": s_cmd, "df": df},
            **{f"{name}_id": getattr(found, name) for name in ("m_e", "k_m", "c_m", "k_p", "c_p")},
            "attributes_valid": m.where(found.valid, 1.0, 0.0),  # a number: many tools connect no Booleans
        }


MODEL = Compensator()

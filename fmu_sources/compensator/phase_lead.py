"""
Displacement phase delay compensation (DPDC): lead on the command of the motion simulator.

    G(s)    = K (1 + alpha T_lead s)/(1 + T_lead s)                                              (22)
    phi_max = arcsin((alpha - 1)/(alpha + 1)),   w_max = 1/(sqrt(alpha) T_lead)                  (23, 24)
    alpha   = (1 + sin phi_max)/(1 - sin phi_max),   T_lead = 1/(w_max sqrt(alpha))
    K       = dpdc_gain/sqrt(alpha) (paper) or dpdc_gain (unit_dc)
    s       = 2/T (1 - q)/(1 + q)                                                                bilinear
    y(k)    = ((2 T_lead - T) y(k-1) + K ((2 alpha T_lead + T) u(k) - (2 alpha T_lead - T) u(k-1)))
              /(2 T_lead + T)

Source   Paper, Sec. IV-C, Eqs. 22-24.
Deviation  T is the sampling time here; Eq. 22's T is T_lead. The paper's K scales every static and ramp
           displacement by 1/sqrt(alpha) and leaves the attenuation of the plant; `unit_dc` and `dpdc_gain`
           are ours: the lead has the gain `dpdc_gain` at w_max (paper) or at rest (unit_dc), 1 in the paper.
"""

from __future__ import annotations

from enum import IntEnum
from typing import Any, NamedTuple

from ..framework.arithmetic import Arithmetic


class GainConvention(IntEnum):
    """Where the lead has the gain dpdc_gain: at its design frequency (the paper) or at rest."""

    paper = 1
    unit_dc = 2


class Lead(NamedTuple):
    """alpha [1], T_lead [s] and K [1] of Eq. 22."""

    alpha: Any
    T_lead: Any
    K: Any


def design(p: Any, m: Arithmetic) -> Lead:
    """Solve Eq. 24 for the largest phase lag dpdc_phase [rad] at dpdc_frequency [Hz]."""
    sine = m.sin(p.dpdc_phase)
    alpha = (1.0 + sine) / (1.0 - sine)
    root = m.sqrt(alpha)
    T_lead = 1.0 / (2.0 * m.pi * p.dpdc_frequency * root)
    K = m.where(p.gain_convention == GainConvention.paper, 1.0 / root, 1.0)
    return Lead(alpha, T_lead, p.dpdc_gain * K)


def command(lead: Lead, y_last: Any, u_last: Any, u: Any, T: Any) -> Any:
    """Give the led command y(k) [m] of the displacement u(k) [m]."""
    pole, zero = 2.0 * lead.T_lead, 2.0 * lead.alpha * lead.T_lead
    return ((pole - T) * y_last + lead.K * ((zero + T) * u - (zero - T) * u_last)) / (pole + T)

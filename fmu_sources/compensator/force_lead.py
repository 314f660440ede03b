"""
Force measurement delay compensation (FMDC): lead against the lag of the force sensor.

    C(s) = (1 + T_f s)/(1 + tau s)                          tau = 0 in the paper                 (14)
    s    = (1 - q)/T                                        backward difference
    f(k) = (tau f(k-1) + (T + T_f) f_mea(k) - T_f f_mea(k-1))/(T + tau)

Source   Paper, Sec. IV-A, Eq. 14.
Deviation  The pole tau is ours; it costs tau of the latency budget. The bilinear form is not offered: its
           pole at -1 rings without end.
Valid    The lead amplifies white noise by about sqrt(2) T_f/T for tau = 0.
"""

from __future__ import annotations

from typing import Any


def lead(f_last: Any, f_mea_last: Any, f_mea: Any, p: Any) -> Any:
    """Give the force [N] before the lag T_f_hat of the sensor."""
    T = p.sample_time
    new = (T + p.T_f_hat) * f_mea - p.T_f_hat * f_mea_last
    return (p.fmdc_filter * f_last + new) / (T + p.fmdc_filter)

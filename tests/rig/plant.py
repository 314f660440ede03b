"""
Right-hand side of the rig between two ticks.

States: 0 s_act, 1 v_act, 2 a_act, 3 x_e, 4 x_e', 5 f_lag, 6 f_mount, 7 f_mount', 8 Bouc-Wen, 9 Dahl,
10 slider, 11.. play operators of the Preisach-like memory, last the second lag of the sensor.
"""

from __future__ import annotations

import math

import numba
import numpy as np

N_PLAYS = 6
SECOND_LAG = 11 + N_PLAYS
N_STATES = SECOND_LAG + 1
PLAY_WIDTHS = np.array([0.2e-3, 0.4e-3, 0.7e-3, 1.1e-3, 1.6e-3, 2.4e-3])
PLAY_WEIGHTS = np.array([0.35, 0.05, 0.25, 0.05, 0.2, 0.1]) / 1e-3
MOUNT, MOUNT_DAMPING = 2.0 * math.pi * 25.0, 0.02
V_0 = 1e-3
PITCH = 0.7e-3


@numba.njit(cache=True)
def rope(t, r, der_r, y, p, e):
    """Force of the rope [N]."""
    k_p = p.k_p * (1.0 - e.thermal * (1.0 - math.exp(-t / 4.0)))
    f = k_p * r + p.c_p * der_r
    if e.backlash > 0.0:
        f -= k_p * min(max(r, -e.backlash), e.backlash)
    f += e.cubic * r**3 + e.quadratic_stiffness * r**2 + e.hertz * max(r, 0.0) ** 1.5
    f += e.end_stop * (r - min(max(r, -2.5e-3), 2.5e-3)) + e.bouc_wen * y[8]
    if e.slack > 0.0:
        f *= 0.5 * math.erfc((r - e.slack) / 2e-5)
    if e.asymmetric_slack > 0.0:
        f *= 1.0 - 0.7 / (1.0 + math.exp(-(r - e.asymmetric_slack) / 2e-4))
    for i in range(N_PLAYS):
        f += e.preisach * PLAY_WEIGHTS[i] * y[11 + i] * (0.7 if y[11 + i] < 0.0 else 1.3)
    return f


@numba.njit(cache=True)
def guide(x_e, v, load, y, e):
    """Friction of the guide [N], positive against positive velocity."""
    sign = math.tanh(v / V_0)
    f = e.coulomb * sign + e.stribeck * math.exp(-((v / 5e-3) ** 2)) * sign
    f += e.quadratic_damping * v * abs(v) + e.dahl * y[9] + e.presliding * y[10]
    f += e.asymmetric_friction * (sign if v > 0.0 else sign / 3.0) + e.load_friction * abs(load) * sign
    f += e.ripple * math.sin(2.0 * math.pi * x_e / PITCH)
    return f + e.position_friction * (1.0 + math.sin(x_e / 4e-4)) * sign


@numba.njit(cache=True)
def yields(v, z, end, width):
    """Rate of an elastic slider: v inside its ends, 0 where it slides."""
    left = (end - z if v > 0.0 else end + z) / width
    return v * min(max(left, 0.0), 1.0)


@numba.njit(cache=True)
def derivatives(t, y, command, p, e, out):
    """Write the rates of all states into `out`."""
    w = p.velocity_bandwidth
    v_cmd = p.position_gain * (command - y[0])
    if e.speed_limit > 0.0:
        v_cmd = min(max(v_cmd, -e.speed_limit), e.speed_limit)
    out[0], out[1] = y[1], y[2]
    out[2] = w * w * (v_cmd - y[1]) - 2.0 * p.velocity_damping * w * y[2]

    r, der_r = y[0] - y[3], y[1] - y[4]
    f_act = -p.k_m * y[3] - p.c_m * y[4]
    out[3] = y[4]
    f_rope = rope(t, r, der_r, y, p, e)
    out[4] = (f_act + f_rope - guide(y[3], y[4], f_rope, y, e)) / p.m_e

    f_felt = f_act + e.inertia * out[4]
    out[6] = y[7]
    out[7] = MOUNT * MOUNT * (f_felt - y[6]) - 2.0 * MOUNT_DAMPING * MOUNT * y[7]
    f_felt += e.mount * (y[6] - f_felt)
    out[5] = (f_felt - y[5]) / (p.T_f + e.slow_filter)
    out[SECOND_LAG] = (y[5] - y[SECOND_LAG]) / e.lag if e.lag > 0.0 else 0.0

    out[8] = (der_r - 0.7 * abs(der_r) * abs(y[8]) * y[8] - 0.3 * der_r * y[8] ** 2) / 1e-3
    out[9] = (y[4] - abs(y[4]) * y[9]) / 0.2e-3
    out[10] = yields(y[4] / 0.3e-3, y[10], 1.0, 0.02)
    for i in range(N_PLAYS):
        out[11 + i] = yields(der_r, y[11 + i], PLAY_WIDTHS[i], 1e-5)

"""The rig's controller and its tick."""

from __future__ import annotations

import math

import numba
import numpy as np

from .plant import N_STATES, SECOND_LAG
from .solver import advance

S_DES, S_CMD, S_ACT, V_ACT, F_DES, F_MEA = range(6)
T = 1e-3  # recorded tick, s
FARTHEST = 1.0  # m


@numba.njit(cache=True)
def contact_coefficients(p, T):
    """Backward-difference coefficients a, b, c, d, e of the contact seen from the frame."""
    d0 = p.m_e + (p.c_m + p.c_p) * T + (p.k_m + p.k_p) * T * T
    a = (2.0 * p.m_e + (p.c_m + p.c_p) * T) / d0
    c = (p.c_m + p.k_m * T) * (p.c_p + p.k_p * T) / d0
    e = p.c_m * p.c_p / d0
    d = -2.0 * e - (p.c_m * p.k_p + p.c_p * p.k_m) * T / d0
    return a, -p.m_e / d0, c, d, e


@numba.njit(cache=True)
def rounded(value, step):
    """Value in steps of a converter; a step of 0 leaves it."""
    return value if step <= 0.0 else step * math.floor(value / step + 0.5)


@numba.njit(cache=True)
def past(history, k, delay):
    """Value `delay` ticks before tick k, cubic between ticks, the first value before the start."""
    place = k - delay
    i = math.floor(place)
    x = place - i
    total = 0.0
    for j in range(-1, 3):
        weight = 1.0
        for other in range(-1, 3):
            if other != j:
                weight *= (x - other) / (j - other)
        total += weight * history[min(max(i + j, 0), k)]
    return total


@numba.njit(cache=True)
def sensed(lagged, k, t, e):
    """Force [N] after delay, gain, offset, drift and the end of the sensor's range."""
    delay = e.delay + e.varying_delay * (0.5 - 0.5 * math.cos(2.0 * math.pi * 0.7 * t))
    f = past(lagged, k, delay / 1e-3) if delay > 0.0 else lagged[k]
    f = f * (1.0 + e.gain) + e.offset + e.drift * t
    if e.force_limit > 0.0:
        f = min(max(f, -e.force_limit), e.force_limit)
    return rounded(f, e.quantisation)


@numba.njit(cache=True)
def run(p, believed, e, q, s0, excitation, noise):
    """
    Run the loop; rows of s_des, s_cmd, s_act, v_act, f_des, f_mea, shape (n, 6).

    Args:
        p: The plant as it is.
        believed: The plant that the compensator believes in.
        e: Effects.
        q: Recorder.
        s0: Initial offset [m].
        excitation: Added to the command [m], shape (n,).
        noise: Standard noise of force, position, velocity, shape (n, 3).
    """
    n, tick = len(excitation), T * (1.0 + q.clock_error)
    rows, lagged, commands = np.zeros((n, 6)), np.zeros(n), np.zeros(n)
    y = np.zeros(N_STATES)
    y[0], y[3] = s0, p.k_p / (p.k_m + p.k_p) * s0
    y[5] = y[6] = y[SECOND_LAG] = -p.k_m * y[3]
    s_des, v_des, last_f, followed, h = s0, 0.0, y[5], s0, 1e-4
    df1 = df2 = ds1 = ds2 = 0.0
    a, b, c, d, e_ = contact_coefficients(believed, T)
    for k in range(n):
        lagged[k] = y[SECOND_LAG] if e.lag > 0.0 else y[5]
        f_mea = rounded(sensed(lagged, k, k * tick, e) + q.sigma * noise[k, 0], q.step_f)
        s_act = rounded(y[0] + q.sigma_s * noise[k, 1], q.step_s)
        ds = s_des - s_act
        df = a * df1 + b * df2 - (c * ds + d * ds1 + e_ * ds2)
        df1, df2, ds1, ds2 = df, df1, ds, ds1
        if e.correction_saturation > 0.0:
            df = min(max(df, -e.correction_saturation), e.correction_saturation)
        if k == 0:
            last_f = f_mea
        f_des = f_mea + believed.T_f * (f_mea - last_f) / T + df
        last_f = f_mea
        s_cmd = rounded(s_des, e.command_quantisation) + excitation[k]
        rows[k] = (s_des, s_cmd, s_act, y[1] + q.sigma_v * noise[k, 2], f_des, f_mea)
        v_des += T * (f_des + e.spacecraft_offset) / p.m_s
        s_des += T * v_des
        commands[k] = s_cmd
        before = k - int(p.dead_time_ticks + e.simulator_delay)
        command = commands[before] if before >= 0 else s0
        if e.rate_limit > 0.0:
            command = followed + min(max(command - followed, -e.rate_limit * tick), e.rate_limit * tick)
        followed = command
        command *= 1.0 + e.simulator_gain
        h = advance(k * tick, (k + 1) * tick, y, command, p, e, h)
        if abs(s_des) > FARTHEST:
            return rows[: k + 1]
    return rows

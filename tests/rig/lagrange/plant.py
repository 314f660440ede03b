"""
The rig as a Lagrangian system with two coordinates, and the implicit midpoint rule that moves it.

    d/dt dT/dq' = -dV/dq - dD/dq' + Q,   q = (s_act, x_e)
    T = (x_e')^2 m_e/2,   V = k_m x_e^2/2 + U(r),   D = c_m x_e'^2/2 + W(r'),   r = s_act - x_e

Spring and damper forces are central differences of the energies, not formulas of their own. The platform is
a servo: s_act' = v, v'' = w^2 (K (cmd - s_act) - v) - 2 z w v'. Laws of `laws.py` add to U, W
or Q by their numbers; several may act at once.

Source: Goldstein, Classical Mechanics, Secs. 1.4, 1.5 (dissipation function); Hairer, Lubich, Wanner,
Geometric Numerical Integration (2006), Sec. I.1.2 (implicit midpoint).
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numba
import numpy as np

STEP_OF_ENERGY = 1e-5  # m, m/s
MOST_ITERATIONS = 60
CLOSE = 1e-15
FRAME = 2.0 * math.pi * 9.0  # 1/s
FRAME_DAMPING = 0.03
ODD_TIMES = np.array([0.61, 1.37, 2.11, 2.93, 3.52, 4.41, 5.07, 5.83, 6.71, 7.26, 8.19, 8.83, 9.47])  # s

S, V, A, X, W, WAY, HEAT, LATE, ARM_1, ARM_2, ARM_3, MODE, MODE_RATE, LAG, DAHL = range(15)
N_STATES = 15


class Body(NamedTuple):
    """Numbers of the rig, SI units."""

    m_e: float = 100.0
    k_m: float = 139_200.0
    c_m: float = 136.1
    k_p: float = 37_760.0
    c_p: float = 97.3
    position_gain: float = 30.0
    velocity_bandwidth: float = 125.66370614359172
    velocity_damping: float = 0.8
    T_f: float = 0.010
    m_s: float = 1000.0


@numba.njit(cache=True)
def is_odd_time(t, width):
    """Whether one of the odd times was at most `width` [s] ago."""
    is_recent = False
    for start in ODD_TIMES:
        is_recent |= 0.0 <= t - start < width
    return is_recent


@numba.njit(cache=True)
def stiffness(t, y, b, laws, sizes):
    """Stiffness of the rope [N/m], as it is now."""
    share = 0.0
    for i, law in enumerate(laws):
        size = sizes[i]
        if law == 7:
            share -= size * t / 10.0
        elif law == 8:
            share += size * math.sin(2.0 * math.pi * (0.4 + 0.11 * t) * t)
        elif law == 9:
            count = 0
            for start in ODD_TIMES:
                if t > start:
                    count += 1
            share += size if count % 2 else 0.0
        elif law == 10:
            share -= size * y[WAY]
        elif law == 103:
            share += size * math.sin(2.0 * math.pi * 1.8 * t + 0.4)
    return b.k_p * (1.0 + share)


@numba.njit(cache=True)
def strain_energy(t, r, y, b, laws, sizes):
    """Energy in the rope [J] at an elongation r [m]."""
    linear = 0.5 * stiffness(t, y, b, laws, sizes) * r * r
    u = linear
    for i, law in enumerate(laws):
        size = sizes[i]
        if law == 1:
            u += size * 0.4e-3 * 0.5 * math.sqrt(math.pi) * math.erf((r - 1e-3) / 0.4e-3)
        elif law == 2:
            z = r / 1.5e-3
            u += -size * 1.5e-3 * (z * z + 1.0) * math.exp(-0.5 * z * z)
        elif law == 3:
            for place in (-1.5e-3, 0.4e-3, 1.7e-3):
                u += size * 1e-4 * math.log(math.cosh((r - place) / 1e-4))
        elif law == 4:
            u += size * (1.5e-3 * math.exp(r / 1.5e-3) - r - 0.5 * r * r / 1.5e-3)
        elif law == 12:
            u -= size * 0.1 * (1.0 - math.exp(-linear / 0.1))
        elif law == 101:
            u += 0.25 * size * r**4
        elif law == 102:
            u += 0.5 * size * max(r - 1.2e-3, 0.0) ** 2
    return u


@numba.njit(cache=True)
def dissipation(r, rate, b, laws, sizes):
    """Rayleigh's function of the rope [W] at a rate of the elongation [m/s]."""
    d = 0.5 * b.c_p * rate * rate
    for i, law in enumerate(laws):
        size = sizes[i]
        if law == 5:
            d += 0.5 * size * math.exp(-((r / 0.6e-3) ** 2)) * rate * rate
        elif law == 6:
            d += 0.5 * size * max(rate, 0.0) ** 2
    return d


@numba.njit(cache=True)
def rope_force(t, r, rate, y, b, laws, sizes):
    """Derivatives of the energies, and what the rope's own memory adds [N]."""
    h = STEP_OF_ENERGY
    f = strain_energy(t, r + h, y, b, laws, sizes) - strain_energy(t, r - h, y, b, laws, sizes)
    f += dissipation(r, rate + h, b, laws, sizes) - dissipation(r, rate - h, b, laws, sizes)
    f /= 2.0 * h
    for i, law in enumerate(laws):
        size = sizes[i]
        if law == 13:
            f += size * ((r - y[ARM_1]) * 0.5 + (r - y[ARM_2]) + (r - y[ARM_3]) * 2.0)
        elif law == 11 and is_odd_time(t, 0.03):
            f *= 1.0 - size
    return f


@numba.njit(cache=True)
def guide_force(t, x, v, acceleration, y, laws, sizes):
    """What the guide does against the motion [N]."""
    sign = math.tanh(v / 1e-3)
    f = 0.0
    for i, law in enumerate(laws):
        size = sizes[i]
        if law == 14:
            f += size * (1.0 + math.sin(x / 0.3e-3)) * v
        elif law == 15:
            f += size * x / 1e-3 * sign
        elif law == 16:
            f += size * max(abs(v) - 8e-3, 0.0) * sign
        elif law == 17:
            f += size * math.exp(-y[HEAT] / 0.08) * sign
        elif law == 18:
            f += size * (1.0 + math.sin(2.0 * math.pi * 0.7 * t)) * sign
        elif law == 19:
            f += size * max(v, 0.0) ** 2
        elif law == 20:
            f += size * y[LATE]
        elif law == 21:
            f += size * sign if is_odd_time(t, 0.04) else 0.0
        elif law == 22:
            f += size * (math.sin(x / 0.15e-3) + math.sin(x / 0.15e-3 * 1.6180339887))
        elif law == 23:
            f += size * abs(acceleration) * sign
        elif law == 104:
            f += size * math.tanh(v / 1e-4)
        elif law == 105:
            f += size * v * abs(v)
        elif law == 106:
            f += size * math.sin(2.0 * math.pi * x / 0.4e-3 + 0.7)
        elif law == 107:
            f += size * (1.0 if v > 0.0 else 0.4) * math.tanh(v / 1e-4)
        elif law == 108:
            f += size * y[DAHL]
    return f


@numba.njit(cache=True)
def rates(t, y, command, b, laws, sizes, out):
    """Write the rates of all states."""
    w = b.velocity_bandwidth
    at = command
    lag = b.T_f
    weaker = 1.0
    for i, law in enumerate(laws):
        size = sizes[i]
        if law == 35:
            at += size * math.sin(command / 0.6e-3)
        elif law == 34:
            weaker -= size
        elif law == 32:
            lag += size * abs(y[LAG])
    wanted = b.position_gain * (at - y[S])
    if wanted > 0.0:
        wanted *= weaker
    out[S] = y[V]
    out[V] = y[A]
    out[A] = w * w * (wanted - y[V]) - 2.0 * b.velocity_damping * w * y[A]
    r = y[S] - y[X]
    rate = y[V] - y[W]
    pull = rope_force(t, r, rate, y, b, laws, sizes)
    base = b.k_m * y[X] + b.c_m * y[W]
    free = (pull - base) / b.m_e
    friction = guide_force(t, y[X], y[W], free, y, laws, sizes)
    out[X] = y[W]
    out[W] = (pull - base - friction) / b.m_e
    out[WAY] = abs(rate)
    out[HEAT] = abs(friction * y[W])
    out[LATE] = (math.tanh(y[W] / 1e-3) - y[LATE]) / 0.015
    out[DAHL] = (y[W] - abs(y[W]) * y[DAHL]) / 0.05e-3
    out[ARM_1] = (r - y[ARM_1]) / 0.01
    out[ARM_2] = (r - y[ARM_2]) / 0.1
    out[ARM_3] = (r - y[ARM_3]) / 1.0
    out[MODE] = y[MODE_RATE]
    out[MODE_RATE] = FRAME * FRAME * (y[A] - y[MODE]) - 2.0 * FRAME_DAMPING * FRAME * y[MODE_RATE]
    out[LAG] = (felt(-base, y, laws, sizes) - y[LAG]) / lag


@numba.njit(cache=True)
def felt(f, y, laws, sizes):
    """Force in front of the sensor's filter [N]."""
    for i, law in enumerate(laws):
        size = sizes[i]
        if law == 29:
            f += size * y[MODE]
        elif law == 31:
            f += size * y[V]
    return f


@numba.njit(cache=True)
def midpoint(t, y, h, command, b, laws, sizes):
    """One step of the implicit midpoint rule, in place, by fixed-point iteration from an explicit one."""
    k = np.empty(N_STATES)
    rates(t, y, command, b, laws, sizes, k)
    new = y + h * k
    for _ in range(MOST_ITERATIONS):
        rates(t + 0.5 * h, 0.5 * (y + new), command, b, laws, sizes, k)
        moved = y + h * k
        far = np.abs(moved - new).max()
        new = moved
        if far <= CLOSE * (1.0 + np.abs(new).max()):
            break
    y[:] = new


@numba.njit(cache=True)
def reading(t, f, laws, sizes):
    """What the sensor makes of the filtered force [N]."""
    for i, law in enumerate(laws):
        size = sizes[i]
        if law == 24:
            f += size * f * abs(f)
        elif law == 25:
            f += size * f**3
        elif law == 26:
            f *= 1.0 + size * math.sin(2.0 * math.pi * 0.9 * t)
        elif law == 27:
            f *= 1.0 - size * (1.0 - math.exp(-t / 3.0))
        elif law == 28:
            f *= 1.0 + size if f > 0.0 else 1.0
        elif law == 33:
            f = math.copysign(100.0 / size * math.log1p(size * abs(f) / 100.0), f)
        elif law == 109:
            f += size
        elif law == 110:
            f += size * t
        elif law == 111:
            f = min(max(f, -size), size)
        elif law == 112:
            f = size * math.floor(f / size + 0.5)
    return f

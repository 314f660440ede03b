"""
The compensated loop as one matrix, from the equations of the paper alone: an oracle for the models.

One period of 1 ms, exact parameters, no noise, backward difference. Plant by matrix exponentials:
the simulator with held command, the contact with inputs linear within the period, the sensor likewise.
"""

from __future__ import annotations

import math

import numpy as np
from scipy.linalg import expm
from scipy.signal import bilinear

T = 1e-3


def first_order_hold(A: np.ndarray, B: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Give F, B_old, B_new of x(k+1) = F x + B_old u(k) + B_new u(k+1), u linear within T."""
    n, m = B.shape
    big = np.zeros((n + 2 * m, n + 2 * m))
    big[:n, :n], big[:n, n : n + m] = A, B
    big[n : n + m, n + m :] = np.eye(m) / T
    E = expm(big * T)
    slope = E[:n, n + m :]
    return E[:n, :n], E[:n, n : n + m] - slope, slope


def loop_matrix(m_s, contact, T_f=0.0, *, cfdc=False, fmdc=False, dpdc=None) -> np.ndarray:
    """Give the matrix of one period; dpdc is (phase [rad], frequency [Hz]) or None."""
    step = _step(m_s, contact, T_f, cfdc=cfdc, fmdc=fmdc, dpdc=dpdc)
    return np.column_stack([step(unit) for unit in np.eye(18)])


def damping(matrix: np.ndarray, frequency: float) -> float:
    """Give the damping ratio of the eigenvalue that is nearest to a frequency [Hz]."""
    z = np.linalg.eigvals(matrix)
    s = np.log(z[np.abs(z) > 1e-6].astype(complex)) / T
    nearest = s[np.argmin(np.abs(s - 2j * math.pi * frequency))]
    return -nearest.real / abs(nearest)


def _step(m_s, contact, T_f, *, cfdc, fmdc, dpdc):
    m_e, k_m, c_m, k_p, c_p = (contact[name] for name in ("m_e", "k_m", "c_m", "k_p", "c_p"))
    K, C = k_m + k_p, c_m + c_p
    K_p, w_v, z = 30.0, 2 * math.pi * 20, 0.8
    A = np.array([[0, 1, 0], [0, 0, 1], [-K_p * w_v**2, -(w_v**2), -2 * z * w_v]])
    big = np.zeros((4, 4))
    big[:3, :3], big[2, 3] = A, K_p * w_v**2
    M = expm(big * T)
    A_c, B_c = np.array([[0, 1], [-K / m_e, -C / m_e]]), np.array([[0, 0], [k_p / m_e, c_p / m_e]])
    F, B_old, B_new = first_order_hold(A_c, B_c)
    if T_f:
        q, g_old, g_new = (
            float(g[0, 0]) for g in first_order_hold(np.array([[-1 / T_f]]), np.array([[1 / T_f]]))
        )
    D0 = m_e + C * T + K * T**2
    a, b = (2 * m_e + C * T) / D0, -m_e / D0
    N = c_m * k_p + c_p * k_m
    c = (c_m * c_p + N * T + k_m * k_p * T**2) / D0
    d, e = -(2 * c_m * c_p + N * T) / D0, c_m * c_p / D0
    if dpdc:
        alpha = (1 + math.sin(dpdc[0])) / (1 - math.sin(dpdc[0]))
        T_lead = 1 / (2 * math.pi * dpdc[1] * math.sqrt(alpha))
        num, den = bilinear(np.array([alpha * T_lead, 1]) / math.sqrt(alpha), [T_lead, 1], 1 / T)

    def step(old):
        s, v, s_a, v_a, a_a, u1, u2, x_e, v_e, y, f_1, y_1, dF1, dF2, ds1, ds2, s_1, led = old
        lead = y + T_f * (y - y_1) / T if fmdc else y
        ds = s - s_a
        dF = a * dF1 + b * dF2 - (c * ds + d * ds1 + e * ds2)
        v_new = v + T * (lead + (dF if cfdc else 0.0)) / m_s
        command = (num[0] * s + num[1] * s_1 - den[1] * led) if dpdc else s
        motion = M[:3] @ [s_a, v_a, a_a, u2]
        ends = F @ [x_e, v_e] + B_old @ [s_a, v_a] + B_new @ motion[:2]
        f = -k_m * ends[0] - c_m * ends[1]
        y_new = q * y + g_old * f_1 + g_new * f if T_f else f
        return np.array(
            [s + T * v_new, v_new, *motion, command, u1, *ends, y_new, f, y, dF, dF1, ds, ds1, s, command]
        )

    return step


def real_matrix(m_s, contact) -> np.ndarray:
    """Give the matrix of the real docking over T, states s, s', x_e, x_e'."""
    m_e, k_m, c_m, k_p, c_p = (contact[name] for name in ("m_e", "k_m", "c_m", "k_p", "c_p"))
    A = np.array(
        [
            [0, 1, 0, 0],
            [0, 0, -k_m / m_s, -c_m / m_s],
            [0, 0, 0, 1],
            [k_p / m_e, c_p / m_e, -(k_m + k_p) / m_e, -(c_m + c_p) / m_e],
        ]
    )
    return expm(A * T)

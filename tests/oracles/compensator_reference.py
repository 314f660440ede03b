"""
Reference experiment of the compensator, computed from the paper's equations in another way than the model.

Matrices for the Kalman filter, SciPy's `lfilter` for leads, prefilter and correction where their coefficients
stand still, all in extended precision, so that the numbers are the truth to the last digits of a double.
"""

from __future__ import annotations

import numpy as np
from scipy.signal import lfilter

from tests.oracles.reference_experiment import Experiment, time_grid

REAL = np.longdouble
N_STEPS = 250
T = REAL(0.001)
AMPLITUDE = 4e-4  # m; small, for with R = 1e-3 N^2 a large force takes digits from any P in doubles
CONTACT = {"m_e": 80, "k_m": 150_000, "c_m": 158, "k_p": 37_900, "c_p": 65}
PARAMETERS: dict[str, float | int | bool] = {
    **{"prior_gain": 0.9, "T_f_hat": 0.012, "fmdc_filter": 0.002},
    **{"dpdc_phase": 0.3, "dpdc_frequency": 1.25},
}
PRESET_F = {"P0_ab": 1e-2, "P0_cde": 1e-2, "R": 1e-3, "prefilter_frequency": 5.0}
TWO_PI = 2 * np.arccos(REAL(-1))


def experiment() -> Experiment:
    """Give the answer to an oscillation like that of Table 1; the parameters keep P well conditioned."""
    inputs = stimuli()
    return Experiment("compensator", time_grid(N_STEPS, 1e-3), PARAMETERS, inputs, answers(inputs))


def stimuli() -> dict[str, np.ndarray]:
    """Make a motion at 1 Hz with a faster part, the simulator 20 ms late, its contact force, a slow drag."""
    t = time_grid(N_STEPS, 1e-3)
    s_des, s_act = motion(t), motion(t - 0.02)
    lagged = motion(t - 0.03) - drag(np.maximum(t - 0.01, 0.0))
    values = {"s_des": s_des, "s_act": s_act, "f_mea": -30_255.0 * lagged, "x": drag(t)}
    return {name: np.round(v, 10) for name, v in values.items()}


def motion(t: np.ndarray) -> np.ndarray:
    """Give a displacement [m] that starts near its largest value."""
    return AMPLITUDE * (0.05 * np.sin(2 * np.pi * 6.1 * t) - np.cos(2 * np.pi * 0.9746 * t))


def drag(t: np.ndarray) -> np.ndarray:
    """Give the travel of the drag mechanism [m]."""
    return 0.2 * AMPLITUDE * t**2


def answers(inputs: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
    """Compute all outputs; row 0 holds the start, row k the answer to the inputs of row k - 1."""
    s_des, s_act, f_mea, x = (REAL(1) * inputs[name] for name in ("s_des", "s_act", "f_mea", "x"))
    T_f, pole = exact("T_f_hat"), exact("fmdc_filter")
    f_lead = filtered([T + T_f, -T_f], [T + pole, -pole], f_mea)
    Y, start = identified(low_passed(f_lead), low_passed(s_act - x))
    dF = correction(Y, s_des - s_act)
    found = {name: held(start[i], Y[:, i]) for i, name in enumerate("abcde")}
    forces = {"f_des": f_lead + dF, "df": dF, "f_lead": f_lead}
    starts = {"f_des": f_mea[0], "df": REAL(0), "f_lead": f_mea[0]}
    return {
        **{n: held(starts[n], v) for n, v in forces.items()},
        "s_cmd": held(s_des[0] / np.sqrt(phase_lead()[0]), phase_led(s_des)),
        **found,
    }


def exact(parameter: str) -> np.longdouble:
    """Give the double that the FMU gets."""
    return REAL({**PARAMETERS, **PRESET_F}[parameter])


def held(start: np.longdouble, steps: np.ndarray) -> np.ndarray:
    """Put the start in front; the inputs of the last row are never used."""
    return np.concatenate([[start], steps[:-1]])


def filtered(numerator: list, denominator: list, u: np.ndarray) -> np.ndarray:
    """Filter, steady at the start in the first value."""
    b, a = (np.array(c, dtype=REAL) for c in (numerator, denominator))
    n = max(len(a), len(b))
    b, a = np.pad(b, (0, n - len(b))) / a[0], np.pad(a, (0, n - len(a))) / a[0]
    gain = b.sum() / a.sum()
    zi = [sum(b[i:] - a[i:] * gain) * u[0] for i in range(1, n)]
    return lfilter(b, a, u, zi=np.array(zi, dtype=REAL))[0]


def low_passed(u: np.ndarray) -> np.ndarray:
    """Apply the prefilter, two equal low-passes."""
    pole = np.exp(-TWO_PI * exact("prefilter_frequency") * T)
    return filtered([1 - pole], [1, -pole], filtered([1 - pole], [1, -pole], u))


def phase_lead() -> tuple[np.longdouble, np.longdouble]:
    """Give alpha and T_lead of Eqs. 23-24, from the half angle."""
    half = np.tan(exact("dpdc_phase") / 2)
    alpha = ((1 + half) / (1 - half)) ** 2
    return alpha, 1 / (TWO_PI * exact("dpdc_frequency") * np.sqrt(alpha))


def phase_led(s_des: np.ndarray) -> np.ndarray:
    """Apply Eq. 22 by the bilinear transformation."""
    alpha, T_lead = phase_lead()
    z, p = 2 * alpha * T_lead / T, 2 * T_lead / T
    K = 1 / np.sqrt(alpha)
    return filtered([K * (1 + z), K * (1 - z)], [1 + p, 1 - p], s_des)


def process_parameters() -> np.ndarray:
    """Give a, b, c, d, e of Eq. 16 by polynomials in q, s = (1 - q)/T."""
    m_e, k_m, c_m, k_p, c_p = (REAL(CONTACT[name]) for name in ("m_e", "k_m", "c_m", "k_p", "c_p"))
    s = np.array([1, -1], dtype=REAL) / T
    one = np.array([1, 0], dtype=REAL)
    numerator = np.convolve(k_m * one + c_m * s, k_p * one + c_p * s)
    denominator = m_e * np.convolve(s, s) + np.convolve((c_m + c_p) * s + (k_m + k_p) * one, one)
    numerator, denominator = numerator / denominator[0], denominator / denominator[0]
    return np.concatenate([-denominator[1:], numerator])


def identified(f: np.ndarray, s: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Run the Kalman filter of Eqs. 19-21 with matrices; give Y after each step and at the start."""
    start = process_parameters() * np.array([1, 1, *3 * [exact("prior_gain")]], dtype=REAL)
    P = np.diag(np.repeat([exact("P0_ab"), exact("P0_cde")], [2, 3]))
    y, R = start, exact("R")
    f_past = np.concatenate([[f[0], f[0]], f])
    s_past = np.concatenate([[s[0], s[0]], s])
    rows = []
    for k, Z in enumerate(f):
        H = np.array([f_past[k + 1], f_past[k], -s_past[k + 2], -s_past[k + 1], -s_past[k]])
        K = P @ H / (H @ P @ H + R)
        y = y + K * (Z - H @ y)
        joseph = np.eye(5, dtype=REAL) - np.outer(K, H)
        P = joseph @ P @ joseph.T + R * np.outer(K, K)
        rows.append(y)
    return np.array(rows), start


def correction(Y: np.ndarray, ds: np.ndarray) -> np.ndarray:
    """Run Eq. 17 with parameters that change at every step, from rest."""
    dF, past = np.zeros(len(ds) + 2, dtype=REAL), np.concatenate([[ds[0], ds[0]], ds])
    for k, y in enumerate(Y):
        dF[k + 2] = y[:2] @ dF[k : k + 2][::-1] - y[2:] @ past[k : k + 3][::-1]
    return dF[2:]

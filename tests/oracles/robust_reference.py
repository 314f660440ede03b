"""
Reference experiment of `robust`: filters as whole arrays, Kalman filters with matrices in Joseph's form.

What identifies the contact reads the inputs alone, so that force and command are put together afterwards;
only the identification of the plant, which reads the command, goes with it. Extended precision.
"""

from __future__ import annotations

import numpy as np
from scipy.signal import lfilter

from tests.oracles.compensator_reference import (
    CONTACT,
    N_STEPS,
    REAL,
    TWO_PI,
    T,
    filtered,
    held,
    stimuli,
)
from tests.oracles.methods_reference import (
    M_S,
    PLANT,
    T_F,
    FourPoles,
    bilinear_contact,
    change,
    derivatives,
    faded,
    inverse,
    late,
    rates,
)
from tests.oracles.reference_experiment import Experiment, time_grid

PARAMETERS: dict[str, float | int | bool] = {
    **{"T_f_hat": T_F, **PLANT},
    **{"wait_cycles": 0.02, "significance": 0.1, "fit_limit": 1e-3, "noise_floor": 0.2},
    **{
        "stiffness_rate": 0.5,
        "model_error": 0.01,
        "slow_prefilter": 4.0,
        "advance": 0.001,
        "force_delay": 0.0005,
    },
    **{"encoder_noise": 1e-5, "plant_lag_tolerance": 0.002},
    "half_first_force": True,
}
STIFFNESS_TOLERANCE = DAMPING_TOLERANCE = REAL(0.2)
SLOW_RATE = REAL(0.002)
GAIN_TOLERANCE = REAL(0.1)
LATENCY_TOLERANCE = REAL(0.3) * REAL(T_F)
RETRO_TIME = REAL(0.1)
INNOVATION_LIMIT = REAL(0.5)
DRIFT = REAL(1e-4)


def experiment() -> Experiment:
    """Give the answer to the motion of the paper's compensator; a latency is adopted and undone early."""
    inputs = {**stimuli(), "a_des": np.round(8.0 * rates(), 9)}
    return Experiment("robust", time_grid(N_STEPS, 1e-3), PARAMETERS, inputs, answers(inputs))


def given(name: str) -> np.longdouble:
    """Give the double that the FMU gets."""
    return REAL(PARAMETERS[name])


class Kalman:
    """Two parameters that drift, by matrices."""

    def __init__(self, variances: np.ndarray, drifts: np.ndarray) -> None:
        self.value = np.zeros(2, dtype=REAL)
        self.P = np.diag(variances)
        self._variances = variances
        self._drifts = drifts

    def step(self, h: np.ndarray, z: np.longdouble, R: np.longdouble) -> None:
        """Take z = h value + noise of variance R; no variance above its first one."""
        P = self.P.copy()
        P[[0, 1], [0, 1]] = np.minimum(np.diag(P) + self._drifts * T, self._variances)
        K = P @ h / (h @ P @ h + R)
        self.value = self.value + K * (z - h @ self.value)
        joseph = np.eye(2, dtype=REAL) - np.outer(K, h)
        self.P = joseph @ P @ joseph.T + R * np.outer(K, K)


def answers(inputs: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
    """Compute both outputs; row 0 holds the start, row k the answer to the inputs of row k - 1."""
    s_des, s_act, f, x = (REAL(1) * inputs[name] for name in ("s_des", "s_act", "f_mea", "x"))
    w_1, t_s, k = prior()
    T_f = given("T_f_hat")
    above, below = bilinear_contact()
    y_d, y_0 = filtered(above, below, s_des - x), filtered(above, below, s_act - x)
    y_a = lagged(y_0, T_f)
    y_l = y_a + T_f / T * change(y_a)
    noise = floored(change_of_change(f) ** 2 / 6)
    slow = Slow(f, y_a, noise, w_1, t_s)
    kappa = fast(f, y_a, noise, slow.adopted, w_1, t_s)
    rate = change(y_l) / T
    residual = f + T_f / T * change(f) + (1 + kappa) * y_l + (slow.adopted - kappa * t_s) * rate
    r = without_noise(residual, f[0] + y_a[0], noise, slow.explained, T_f)
    f_e = undone(slow.latency, rate, kappa, k, t_s)
    damping = slow.adopted - slow.latency - kappa * t_s
    der = change(y_d) / T
    f_comp = r - (1 + kappa) * (y_d + given("force_delay") * der) - damping * der + f_e
    f_comp[0] /= 2
    start = f[0] + k * (s_act[0] - s_des[0])
    s_cmd = command(s_des, s_act, f_comp / M_S, start / M_S, w_1)
    return {"f_comp": held(start, f_comp), "s_cmd": held(s_des[0], s_cmd)}


def prior() -> tuple[np.longdouble, np.longdouble, np.longdouble]:
    """Give loop frequency [rad/s], loss [s] and stiffness [N/m] of the believed contact."""
    m_e, k_m, c_m, k_p, c_p = (REAL(CONTACT[name]) for name in ("m_e", "k_m", "c_m", "k_p", "c_p"))
    K = k_m + k_p
    half = K / (2 * m_e)
    w_1 = np.sqrt(half - np.sqrt(half**2 - k_m * k_p / (M_S * m_e)))
    return w_1, c_m / k_m + c_p / k_p - (c_m + c_p) / K, k_m * k_p / K


def lagged(y: np.ndarray, T_f: np.longdouble) -> np.ndarray:
    """Give the answer of a lag to straight lines between the samples, steady at the start."""
    q = np.exp(-T / T_f)
    mean = T_f / T * (1 - q)
    return filtered([1 - mean, mean - q], [1, -q], y)


def change_of_change(u: np.ndarray) -> np.ndarray:
    """Give the second difference, 0 at the start."""
    return change(change(u))


def floored(squares: np.ndarray) -> np.ndarray:
    """Average over 0.2 s, nowhere below the floor."""
    least = given("noise_floor") ** 2
    share = T / REAL(0.2)
    level, found = least, []
    for one in squares:
        level = max((1 - share) * level + share * one, least)
        found.append(level)
    return np.array(found)


def four_poles(u: np.ndarray, w: np.longdouble) -> np.ndarray:
    """Apply four equal poles at w [rad/s]."""
    pole = np.exp(-w * T)
    for _ in range(4):
        u = filtered([1 - pole], [1, -pole], u)
    return u


def averaged(u: np.ndarray, share: np.longdouble, start: np.longdouble) -> np.ndarray:
    """Average with a memory that fades, from `start`."""
    return lfilter(np.array([share]), np.array([1, share - 1]), u, zi=np.array([(1 - share) * start]))[0]


class Slow:
    """Stiffness and time error by the slow filter: what of the latter is adopted, and what is latency [s]."""

    def __init__(
        self, f: np.ndarray, y_a: np.ndarray, noise: np.ndarray, w_1: np.longdouble, t_s: np.longdouble
    ) -> None:
        corner = given("slow_prefilter") * w_1
        F, A = four_poles(f, corner), four_poles(y_a, corner)
        der = change(A) / T
        w = T * w_1 / TWO_PI
        variance = LATENCY_TOLERANCE**2 + (DAMPING_TOLERANCE * t_s) ** 2
        self.explained = averaged(A**2, w, y_a[0] ** 2)
        kalman = Kalman(
            np.array([STIFFNESS_TOLERANCE**2, variance]), np.array([SLOW_RATE**2, DRIFT * variance])
        )
        R = noise + given("model_error") ** 2 * (A**2 + (der / w_1) ** 2)
        factor = np.exp(2 * DAMPING_TOLERANCE)
        adopted, latency, unexplained = REAL(0), REAL(0), REAL(0)
        was_adopted, was_latency = False, False
        rows = []
        for k, z in enumerate(F + A):
            h = -np.array([A[k] - t_s * der[k], der[k]])
            kalman.step(h, z, R[k])
            eps = kalman.value[1]
            unexplained = (1 - w) * unexplained + w * (z - h @ kalman.value) ** 2
            fits = unexplained < given("fit_limit") * self.explained[k] + REAL(0.05) * noise[k]
            needed = given("significance") / (2 if was_adopted else 1)
            is_adopted = bool(
                (k + 1) * w > given("wait_cycles") and fits and eps**2 > needed**2 * kalman.P[1, 1]
            )
            slack = REAL(0.8) if was_latency else REAL(1)
            is_latency = bool(not t_s * slack * (1 / factor - 1) <= eps <= t_s * slack * (factor - 1))
            share = w / REAL(0.1) if is_adopted else w / REAL(0.3)
            adopted = (1 - share) * adopted + (share * eps if is_adopted else 0)
            latency = (1 - share) * latency + (share * eps if is_adopted and is_latency else 0)
            was_adopted, was_latency = is_adopted, is_latency
            rows.append([adopted, latency])
        self.adopted, self.latency = np.array(rows).T


def fast(
    f: np.ndarray,
    y_a: np.ndarray,
    noise: np.ndarray,
    eps: np.ndarray,
    w_1: np.longdouble,
    t_s: np.longdouble,
) -> np.ndarray:
    """Give the stiffness error kappa [1] at each instant."""
    F, _ = second_order(f)
    A, der_A = second_order(y_a)
    h = t_s * der_A - A
    z = F + A + eps * der_A
    R = noise + given("model_error") ** 2 * (A**2 + (der_A / w_1) ** 2)
    kappa, P, size, found = REAL(0), STIFFNESS_TOLERANCE**2, REAL(0), []
    for k in range(len(z)):
        P = P + T * (given("stiffness_rate") * min(REAL(1), size / INNOVATION_LIMIT)) ** 2
        S = h[k] ** 2 * P + R[k]
        innovation = z[k] - h[k] * kappa
        kappa = min(max(kappa + P * h[k] / S * innovation, REAL(-0.95)), REAL(2))
        P = P * R[k] / S
        size = size + T / REAL(0.05) * (innovation**2 / S - size)
        found.append(kappa)
    return np.array(found)


def second_order(u: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """
    Give value and rate after 10 Hz and a damping of 0.7, implicit in the damping.

    rate = (rate' + T w^2 (u - value'))/D and value = value' + T rate, as one filter of the value.
    """
    w = TWO_PI * 10
    D = 1 + REAL(1.4) * T * w + (T * w) ** 2
    gain = (T * w) ** 2 / D
    value = filtered([gain], [1, gain - 1 - 1 / D, 1 / D], u)
    return value, np.diff(value, prepend=u[0]) / T


def without_noise(
    residual: np.ndarray,
    before: np.longdouble,
    noise: np.ndarray,
    explained: np.ndarray,
    T_f: np.longdouble,
) -> np.ndarray:
    """
    Take of each band how much is not noise; the lower one is steady in `before` at the start.

    The noise of each band is the sum of squares of what it answers to one pulse of the force.
    """
    a = 1 - np.exp(-TWO_PI * 3 * T)
    pulse = np.zeros(4000, dtype=REAL)
    pulse[0], pulse[1] = 1 + T_f / T, -T_f / T
    low_pulse = lfilter(np.array([a]), np.array([1, a - 1]), pulse)
    low_noise, high_noise = np.sum(low_pulse**2) * noise, np.sum((pulse - low_pulse) ** 2) * noise
    low = averaged(residual, a, before)
    high = residual - low
    low_variance = averaged(low**2, T / REAL(0.05), before**2)
    high_variance = faded(high**2, REAL(0.5))
    low_share, high_share = (
        1 / (1 + (n * level / variance) ** 2)
        for n, level, variance in (
            (8, low_noise, low_variance),
            (4, high_noise, np.maximum(high_variance, REAL(1e-300))),
        )
    )
    return low * low_share + high * np.where(noise > REAL(1e-4) * explained, high_share, REAL(1))


def undone(
    latency: np.ndarray, rate: np.ndarray, kappa: np.ndarray, k: np.longdouble, t_s: np.longdouble
) -> np.ndarray:
    """Give the force that takes back what a latency has moved."""
    w, c = 1 / RETRO_TIME, t_s * k
    moved, error, found = np.zeros(2, dtype=REAL), np.zeros(2, dtype=REAL), []
    for i, d in enumerate(np.diff(latency, prepend=REAL(0))):
        error = error + d * moved
        stiffness = (1 + kappa[i]) * k
        pull = np.array([w**2, 2 * w]) @ error
        found.append(M_S * pull - np.array([stiffness, c]) @ error)
        v = moved[1] + T / M_S * (rate[i] - np.array([stiffness, c]) @ moved)
        moved = np.array([moved[0] + T * v, v])
        v = error[1] - T * pull
        error = np.array([error[0] + T * v, v])
    return np.array(found)


def command(
    s_des: np.ndarray, s_act: np.ndarray, a: np.ndarray, first: np.longdouble, w_1: np.longdouble
) -> np.ndarray:
    """Give the command, led by what the plant was found to lack."""
    corner = REAL(6) * w_1
    s, v, a, j = derivatives(s_des, a, first)
    believed = {name: given(name) for name in PLANT}
    to, d = inverse(believed, given("advance")), inverse(believed)
    wanted = np.array([to @ np.array([s, v, a, j]), to[:3] @ np.array([v, a, j])])
    reached = late(four_poles(s_act, corner), 3)
    h = np.array([d @ reached, d[:3] @ reached[1:]])
    R = given("encoder_noise") ** 2 + given("model_error") ** 2 * (h[0] ** 2 + (h[1] / w_1) ** 2)
    lag_variance = given("plant_lag_tolerance") ** 2
    kalman = Kalman(
        np.array([GAIN_TOLERANCE**2, lag_variance]), np.array([SLOW_RATE**2, DRIFT * lag_variance])
    )
    poles = FourPoles(s_act[0], corner / TWO_PI)
    found = []
    for k in range(len(s)):
        found.append((np.array([1, 0]) + kalman.value) @ wanted[:, k])
        kalman.step(h[:, k], poles.step(found[-1]) - h[0, k], R[k])
    return np.array(found)

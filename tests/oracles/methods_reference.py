"""
Reference experiments of the methods that the paper's compensator is compared with.

Whole arrays in extended precision where a method does not feed its command back, SciPy's `lfilter` for every
filter and every memory that fades, Cramer's rule where the models eliminate.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from scipy.signal import lfilter

from tests.oracles.compensator_reference import (
    AMPLITUDE,
    CONTACT,
    N_STEPS,
    REAL,
    TWO_PI,
    T,
    filtered,
    held,
    stimuli,
)
from tests.oracles.reference_experiment import Experiment, time_grid

Values = dict[str, float | int | bool]
Answer = dict[str, np.ndarray]

M_S = 820
T_F = 0.012
PLANT = {"K_p": 28.0, "w_v": 120.0, "z": 0.75, "dead_time": 0.003}
INVERTED = {"T_f_hat": T_F, **PLANT}


def experiments() -> dict[str, Callable[[], Experiment]]:
    """Map each method to the maker of its experiment."""
    return {
        "virtual_damper": lambda: made(virtual_damper, {"stiffness": 28_000.0, "latency": 0.04}),
        "virtual_force": lambda: made(virtual_force, {"stiffness": 28_000.0}),
        "force_lead": lambda: made(force_lead, {"latency": 0.04}),
        "cr_inverse": lambda: made(cr_inverse, {"lag": 0.03, "T_f_hat": T_F}),
        "horiuchi": lambda: made(horiuchi, {"lag": 0.0201, "T_f_hat": T_F}),
        "inverse3": lambda: made(inverse3, INVERTED),
        "ats": lambda: made(ats, {**INVERTED, "memory": 0.4, "bound": 0.6}),
        "amb": lambda: made(amb, {**INVERTED, "rate": 3.0, "filter_frequency": 15.0, "uses_a_des": True}),
        "qi": lambda: made(qi, {**INVERTED, "stiffness": 28_000.0, "damping": 60.0, "memory": 0.2}),
        "smith": lambda: made(smith, {**INVERTED, "s_act": float(stimuli()["s_act"][0])}),
        "tdpa": lambda: made(tdpa, {**INVERTED, "largest_damping": 300.0}),
    }


def made(method: Callable[[Answer, Values], Answer], values: Values) -> Experiment:
    """
    Answer the stimuli of the paper's compensator by a method.

    v_des is the rate of s_des; a_des is another motion's, so that it shows which acceleration was taken.
    """
    inputs = {**stimuli(), "v_des": rates(), "a_des": np.round(8.0 * rates(), 9)}
    exact = {name: REAL(1) * column for name, column in inputs.items()}
    outputs = method(exact, {name: REAL(value) for name, value in values.items()})
    used = {name: column for name, column in inputs.items() if name in USED[method.__name__]}
    return Experiment(method.__name__, time_grid(N_STEPS, 1e-3), values, used, outputs)


USED = {
    "virtual_damper": {"s_des", "f_mea", "v_des"},
    "virtual_force": {"s_des", "s_act", "f_mea"},
    "force_lead": {"s_des", "f_mea"},
    "cr_inverse": {"s_des", "f_mea"},
    "horiuchi": {"s_des", "f_mea"},
    "inverse3": {"s_des", "f_mea", "a_des"},
    "ats": {"s_des", "s_act", "f_mea", "a_des"},
    "amb": {"s_des", "s_act", "f_mea", "a_des"},
    "qi": {"s_des", "s_act", "f_mea", "x", "a_des"},
    "smith": {"s_des", "f_mea", "x", "a_des"},  # s_act at the start alone, which is a value
    "tdpa": {"s_des", "s_act", "f_mea", "a_des"},
}


def rates() -> np.ndarray:
    """Give the rate [m/s] of the desired motion, from its closed form."""
    t = time_grid(N_STEPS, 1e-3)
    fast, slow = 2 * np.pi * 6.1, 2 * np.pi * 0.9746
    return np.round(AMPLITUDE * (0.05 * fast * np.cos(fast * t) + slow * np.sin(slow * t)), 9)


def change(u: np.ndarray) -> np.ndarray:
    """Give u(k) - u(k-1), 0 at the start."""
    return np.diff(u, prepend=u[0])


def led(f: np.ndarray, T_f: np.longdouble) -> np.ndarray:
    """Lead a force by T_f."""
    return f + T_f / T * change(f)


def low_passed(u: np.ndarray, frequency: np.longdouble) -> np.ndarray:
    """Apply four equal poles, steady at the start."""
    pole = np.exp(-TWO_PI * frequency * T)
    for _ in range(4):
        u = filtered([1 - pole], [1, -pole], u)
    return u


def faded(u: np.ndarray, memory: np.longdouble) -> np.ndarray:
    """Average with a memory that fades, from 0."""
    return lfilter(np.array([T / memory]), np.array([REAL(1), T / memory - 1]), u)


def inverse(p: Values, ahead: float = 0.0) -> np.ndarray:
    """Give 1, d_1, d_2, d_3: the product of two series."""
    tau = p["dead_time"] + T / 2 + ahead
    delay = np.array([1, tau, tau**2 / 2, tau**3 / 6])
    K, w, z = p["K_p"], p["w_v"], p["z"]
    lag = np.array([1, 1 / K, 2 * z / (w * K), 1 / (w**2 * K)])
    return np.convolve(delay, lag)[:4]


def derivatives(s: np.ndarray, a: np.ndarray, first: np.longdouble) -> np.ndarray:
    """Give s, v, a, j at each instant, shape (4, n); `first` is a before the first one."""
    return np.array([s, change(s) / T + T / 2 * a, a, np.diff(a, prepend=first) / T])


def inverted(u: Answer, f_comp: np.ndarray, p: Values, start: np.longdouble) -> np.ndarray:
    """Give the command of the third-order inverse."""
    return inverse(p) @ derivatives(u["s_des"], f_comp / M_S, start / M_S)


def both(u: Answer, f_comp: np.ndarray, s_cmd: np.ndarray, start: np.longdouble | None = None) -> Answer:
    """Put the start in front of force and command."""
    f_0 = u["f_mea"][0] if start is None else start
    return {"f_comp": held(f_0, f_comp), "s_cmd": held(u["s_des"][0], s_cmd)}


def virtual_damper(u: Answer, p: Values) -> Answer:
    force = u["f_mea"] - p["stiffness"] * p["latency"] * u["v_des"]
    return both(u, force, u["s_des"], force[0])


def virtual_force(u: Answer, p: Values) -> Answer:
    force = u["f_mea"] - p["stiffness"] * (u["s_des"] - u["s_act"])
    return both(u, force, u["s_des"], force[0])


def force_lead(u: Answer, p: Values) -> Answer:
    return both(u, led(u["f_mea"], p["latency"]), u["s_des"])


def cr_inverse(u: Answer, p: Values) -> Answer:
    alpha = 1 + p["lag"] / T
    return both(u, led(u["f_mea"], p["T_f_hat"]), filtered([alpha, 1 - alpha], [1], u["s_des"]))


def horiuchi(u: Answer, p: Values) -> Answer:
    """20 periods: 20.1 ms are rounded."""
    s, n = u["s_des"], 20
    earlier = np.concatenate([np.repeat(s[0], 3 * n), s])
    points = [earlier[3 * n - i * n : len(earlier) - i * n] for i in range(4)]
    return both(u, led(u["f_mea"], p["T_f_hat"]), np.array([4, -6, 4, -1], dtype=REAL) @ np.array(points))


def inverse3(u: Answer, p: Values) -> Answer:
    force = led(u["f_mea"], p["T_f_hat"])
    return both(u, force, inverted(u, force, p, u["f_mea"][0]))


def qi(u: Answer, p: Values) -> Answer:
    force = led(u["f_mea"], p["T_f_hat"])
    s = low_passed(u["s_act"] - u["x"], REAL(10))
    scale = REAL(0.1)
    phi = np.array([s, scale / T * change(s)])
    left = -low_passed(force, REAL(10)) - p["stiffness"] * s - p["damping"] * change(s) / T
    (a, b), (_, d) = [[faded(one * other, p["memory"]) for other in phi] for one in phi]
    a, d = a + REAL(1e-9), d + REAL(1e-9)
    r, q = (faded(one * left, p["memory"]) for one in phi)
    k = p["stiffness"] + (d * r - b * q) / (a * d - b * b)
    c = p["damping"] + scale * (a * q - b * r) / (a * d - b * b)
    missing = u["s_des"] - u["s_act"]
    f_comp = force - k * missing - c / T * change(missing)
    return both(u, f_comp, inverted(u, f_comp, p, u["f_mea"][0]))


def tdpa(u: Answer, p: Values) -> Answer:
    force = led(u["f_mea"], p["T_f_hat"])
    v, v_act = change(u["s_des"]) / T, change(u["s_act"]) / T
    energy, f_comp = REAL(0), force.copy()
    for k in range(1, len(v)):
        energy += T * force[k] * (v[k] - v_act[k])
        beta = min(max(energy, REAL(0)) / (T * v[k] ** 2), p["largest_damping"])
        f_comp[k] -= beta * v[k]
        energy = max(energy - T * beta * v[k] ** 2, REAL(0))
    return both(u, f_comp, inverted(u, f_comp, p, u["f_mea"][0]))


def amb(u: Answer, p: Values) -> Answer:
    force = led(u["f_mea"], p["T_f_hat"])
    d = inverse(p)
    wanted = d[:, None] * derivatives(u["s_des"], u["a_des"], u["a_des"][0])
    phi = d[:, None] * late(low_passed(u["s_act"], p["filter_frequency"]), 3)
    theta, s_cmd = np.ones(4, dtype=REAL), np.zeros_like(force)
    poles = FourPoles(u["s_act"][0], p["filter_frequency"])
    for k in range(len(s_cmd)):
        s_cmd[k] = theta @ wanted[:, k]
        left = poles.step(s_cmd[k]) - theta @ phi[:, k]
        theta = theta + T * p["rate"] * left * phi[:, k] / (REAL(1e-6) ** 2 + phi[:, k] @ phi[:, k])
    return both(u, force, s_cmd)


def ats(u: Answer, p: Values) -> Answer:
    force = led(u["f_mea"], p["T_f_hat"])
    d = inverse(p)[:3]
    wanted = d[:, None] * derivatives(u["s_des"], force / M_S, u["f_mea"][0] / M_S)[:3]
    phi = d[:, None] * late(low_passed(u["s_act"], REAL(20)), 2)
    normal = np.array([[held(REAL(0), faded(a * b, p["memory"])) for b in phi] for a in phi])
    normal = normal + REAL(1e-10) * np.eye(3, dtype=REAL)[:, :, None]
    right, s_cmd = np.zeros(3, dtype=REAL), np.zeros_like(force)
    poles = FourPoles(u["s_act"][0], REAL(20))
    for k in range(len(s_cmd)):
        changes = np.clip(cramer(normal[:, :, k], right), -p["bound"], p["bound"])
        s_cmd[k] = (1 + changes) @ wanted[:, k]
        left = poles.step(s_cmd[k]) - np.sum(phi[:, k])
        right = right + T / p["memory"] * (phi[:, k] * left - right)
    return both(u, force, s_cmd)


def smith(u: Answer, p: Values) -> Answer:
    """The plant by the matrix exponential's series to fourth order, the contact by polynomials in q."""
    c, d = bilinear_contact()
    led_force = led(u["f_mea"], p["T_f_hat"])
    y_d = filtered(c, d, u["s_des"] - u["x"])
    phi, gamma = plant(p)
    n_dead = 3
    state = np.array([u["s_act"][0], 0, 0], dtype=REAL)
    s_cmd, f_comp = np.zeros_like(y_d), np.zeros_like(y_d)
    first = u["s_act"][0] - u["x"][0]
    s_past, y_past = np.repeat(first, 2), np.repeat(c.sum() / d.sum() * first, 2)
    start = u["f_mea"][0] / M_S
    for k in range(len(y_d)):
        modelled = state[0] - u["x"][k]
        y_m = c[0] * modelled + c[1:] @ s_past - d[1:] @ y_past
        s_past, y_past = np.array([modelled, s_past[0]]), np.array([y_m, y_past[0]])
        f_comp[k] = led_force[k] + y_m - y_d[k]
        motion = derivatives(u["s_des"][: k + 1], f_comp[: k + 1] / M_S, start)[:, k]
        s_cmd[k] = inverse(p) @ motion
        acting = s_cmd[k - n_dead] if k >= n_dead else u["s_act"][0]
        state = phi @ state + gamma * acting
    steady = c.sum() / d.sum() * (u["s_act"][0] - u["s_des"][0])
    return both(u, f_comp, s_cmd, u["f_mea"][0] + steady)


def bilinear_contact() -> tuple[np.ndarray, np.ndarray]:
    """Give numerator and denominator of the contact in q, s = 2 (1 - q)/(T (1 + q)), the latter from 1 on."""
    m_e, k_m, c_m, k_p, c_p = (REAL(CONTACT[name]) for name in ("m_e", "k_m", "c_m", "k_p", "c_p"))
    s, one = np.array([2, -2], dtype=REAL) / T, np.array([1, 1], dtype=REAL)
    above = np.convolve(k_m * one + c_m * s, k_p * one + c_p * s)
    below = m_e * np.convolve(s, s) + np.convolve((c_m + c_p) * s + (k_m + k_p) * one, one)
    return above / below[0], below / below[0]


def plant(p: Values) -> tuple[np.ndarray, np.ndarray]:
    """Give Phi and Gamma of a period with the command held."""
    K, w, z = p["K_p"], p["w_v"], p["z"]
    A = np.array([[0, 1, 0], [0, 0, 1], [-(w**2) * K, -(w**2), -2 * z * w]], dtype=REAL)
    B = np.array([0, 0, w**2 * K], dtype=REAL)
    phi = series = np.eye(3, dtype=REAL)
    gamma = integral = T * np.eye(3, dtype=REAL)
    for n in range(1, 5):
        series = series @ A * T / n
        phi = phi + series
    for n in range(2, 5):
        integral = integral @ A * T / n
        gamma = gamma + integral
    return phi, gamma @ B


def late(s: np.ndarray, order: int) -> np.ndarray:
    """Give s and its derivatives up to `order`, each made timely by the differences of higher order."""
    once, twice, thrice = change(s), change(change(s)), change(change(change(s)))
    if order == 2:
        return np.array([s, (once + twice / 2) / T, twice / T**2])
    return np.array([s, (once + twice / 2 + thrice / 3) / T, (twice + thrice) / T**2, thrice / T**3])


def cramer(A: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Solve three equations by cross products."""
    columns = A.T
    volume = columns[0] @ np.cross(columns[1], columns[2])
    return (
        np.array(
            [
                b @ np.cross(columns[1], columns[2]),
                columns[0] @ np.cross(b, columns[2]),
                columns[0] @ np.cross(columns[1], b),
            ]
        )
        / volume
    )


class FourPoles:
    """Four equal poles, step by step: the fourth power of one as a recursion over past outputs."""

    def __init__(self, start: np.longdouble, frequency: np.longdouble) -> None:
        pole = np.exp(-TWO_PI * frequency * T)
        self._back = -np.array([-4 * pole, 6 * pole**2, -4 * pole**3, pole**4])
        self._gain = (1 - pole) ** 4
        self._past = np.repeat(start, 4)

    def step(self, u: np.longdouble) -> np.longdouble:
        """Give the next output."""
        y = self._gain * u + self._back @ self._past
        self._past = np.concatenate([[y], self._past[:3]])
        return y

"""
Reference experiments of the linear subsystems, solved exactly with the matrix exponential.

The inputs of a row are set at its time and hold for one step; a model that interpolates goes from those of
the row before to those of the row. The continuous models integrate with Runge-Kutta and come within 1e-8.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
from scipy.linalg import expm

from tests.oracles.reference_experiment import Experiment, time_grid

T = 1e-3
N_STEPS = 250
TIME = time_grid(N_STEPS, T)
CONTACT = {"m_e": 78.0, "k_m": 48587.0, "c_m": 125.23, "k_p": 84408.0, "c_p": 82.55}

Rows = dict[str, np.ndarray]


def wave(amplitude: float, frequency: float, digits: int = 9) -> np.ndarray:
    """Give a cosine of time with few digits, so that a CSV holds it exactly."""
    return np.round(amplitude * np.cos(2 * np.pi * frequency * TIME), digits)


def solve(A: np.ndarray, B: np.ndarray, x: np.ndarray, courses: Iterator) -> np.ndarray:
    """
    Solve x' = A x + B u exactly, step by step.

    Args:
        A: Shape (n, n).
        B: Shape (n, m).
        x: Start, shape (n,).
        courses: For each step the inputs at its begin and at its end, linear between.

    Returns:
        States at the start and after each step, shape (steps + 1, n).
    """
    n, m = B.shape
    system = np.zeros((n + 2 * m, n + 2 * m))
    system[:n, :n], system[:n, n : n + m] = A, B
    system[n : n + m, n + m :] = np.eye(m) / T
    step = expm(system * T)[:n]
    rows = [x]
    for begin, end in courses:
        rows.append(step @ np.concatenate([rows[-1], begin, np.subtract(end, begin)]))
    return np.array(rows)


def held(inputs: np.ndarray) -> Iterator:
    """Hold each row for its step."""
    return ((row, row) for row in inputs[:-1])


def interpolated(inputs: np.ndarray) -> Iterator:
    """Go from the row before to the row; the first one stands."""
    return zip(np.vstack([inputs[:1], inputs])[:N_STEPS], inputs[:-1], strict=True)


def spacecraft() -> Experiment:
    """A mass under a force that is held: parabolas, joined."""
    p = {"m_s": 900.0, "integrator": 2, "s_des": -0.01, "v_des": 0.002}
    f = wave(300.0, 1.7, 6)
    A, B = np.array([[0.0, 1.0], [0.0, 0.0]]), np.array([[0.0], [1 / p["m_s"]]])
    x = solve(A, B, np.array([p["s_des"], p["v_des"]]), held(f[:, None]))
    return Experiment("spacecraft", TIME, p, {"f": f}, {"s_des": x[:, 0], "v_des": x[:, 1]})


def motion_simulator_linear() -> Experiment:
    """Third order behind a delay of whole periods."""
    p = {"K_p": 28.0, "w_v": 110.0, "z": 0.7, "dead_time": 0.003, "s_act": -0.01}
    s_cmd = wave(-0.01, 2.3)
    w2 = p["w_v"] ** 2
    A = np.array([[0, 1, 0], [0, 0, 1], [-p["K_p"] * w2, -w2, -2 * p["z"] * p["w_v"]]])
    B = np.array([[0.0], [0.0], [p["K_p"] * w2]])
    late = np.concatenate([np.full(3, p["s_act"]), s_cmd])[: N_STEPS + 1]
    x = solve(A, B, np.array([p["s_act"], 0.0, 0.0]), held(late[:, None]))
    outputs = {"s_act": x[:, 0], "v_act": x[:, 1]}
    return Experiment("motion_simulator_linear", TIME, p, {"s_cmd": s_cmd}, outputs)


def contact_matrices() -> tuple[np.ndarray, np.ndarray]:
    """End-effector on two springs, states x_e, x_e', x; inputs s, s', v."""
    m_e, k_m, c_m, k_p, c_p = (CONTACT[n] for n in ("m_e", "k_m", "c_m", "k_p", "c_p"))
    A = np.array([[0, 1, 0], [-(k_m + k_p) / m_e, -(c_m + c_p) / m_e, -k_p / m_e], [0, 0, 0]])
    B = np.array([[0, 0, 0], [k_p / m_e, c_p / m_e, -c_p / m_e], [0, 0, 1]])
    return A, B


def force() -> np.ndarray:
    """Row that gives the force at the frame side from x_e, x_e', x."""
    return np.array([-CONTACT["k_m"], -CONTACT["c_m"], 0.0])


def docking_contact() -> Experiment:
    """The contact under a given motion, and a drag."""
    p = {**CONTACT, "x": 0.001}
    inputs = {"s_act": wave(-0.01, 2.6), "v_act": wave(0.05, 2.1), "v": wave(0.02, 3.0)}
    A, B = contact_matrices()
    rest = CONTACT["k_p"] / (CONTACT["k_m"] + CONTACT["k_p"]) * (inputs["s_act"][0] - p["x"])
    x = solve(A, B, np.array([rest, 0.0, p["x"]]), interpolated(np.column_stack([*inputs.values()])))
    return Experiment("docking_contact", TIME, p, inputs, {"f_act": x @ force(), "x": x[:, 2]})


def real_docking() -> Experiment:
    """Spacecraft and contact in one, under a drag."""
    p = {**CONTACT, "m_s": 550.0, "s": -0.01, "v_s": 0.003, "x": 0.001}
    v = wave(0.02, 3.0)
    contact, drive = contact_matrices()
    A = np.zeros((5, 5))
    A[0, 1] = 1.0
    A[1, 2:] = force() / p["m_s"]
    A[2:, 2:], A[2:, :2] = contact, drive[:, :2]
    B = np.concatenate([[0.0, 0.0], drive[:, 2]])[:, None]
    rest = CONTACT["k_p"] / (CONTACT["k_m"] + CONTACT["k_p"]) * (p["s"] - p["x"])
    x = solve(A, B, np.array([p["s"], p["v_s"], rest, 0.0, p["x"]]), held(v[:, None]))
    outputs = {"s": x[:, 0], "v_s": x[:, 1], "x": x[:, 4], "f": x[:, 2:] @ force()}
    return Experiment("real_docking", TIME, p, {"v": v}, outputs)


def force_sensor() -> Experiment:
    """Lag on a force that is linear from row to row, and noise from L'Ecuyer's generator in whole numbers."""
    p = {"T_f": 0.008, "sigma": 0.05, "offset": 1.5, "seed": 7}
    f = wave(300.0, 4.0, 6)
    pole = np.array([[-1 / p["T_f"]]])
    lagged = solve(pole, -pole, f[:1], interpolated(f[:, None]))[:, 0]
    noise = np.array(list(normal_numbers(int(p["seed"]), N_STEPS + 1)))
    outputs = {"f_mea": lagged + p["offset"] + p["sigma"] * noise}
    return Experiment("force_sensor", TIME, p, {"f_act": f}, outputs)


def normal_numbers(seed: int, n: int) -> Iterator[float]:
    """Draw with MRG32k3a and the transformation of Box and Muller, n numbers."""
    m1, m2 = 2**32 - 209, 2**32 - 22853
    state, last = [], seed + 1
    for modulus in (m1, m1, m1, m2, m2, m2):
        last = 1403580 * last % modulus
        state.append(last)
    first, second = state[:3], state[3:]
    for _ in range(n):
        uniform = []
        for _ in range(2):
            first = [*first[1:], (1403580 * first[1] - 810728 * first[0]) % m1]
            second = [*second[1:], (527612 * second[2] - 1370589 * second[0]) % m2]
            uniform.append(((first[2] - second[2]) % m1 or m1) / (m1 + 1))
        yield math.sqrt(-2 * math.log(uniform[0])) * math.cos(2 * math.pi * uniform[1])

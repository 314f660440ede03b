"""
The paper's loop without compensation and dead time: its monolithic solution, and how it is coupled.

    m_s s_des''  = f_mea                                                                     (1)
    s_act''' + 2 z w_v s_act'' + w_v^2 s_act' + K_p w_v^2 s_act = K_p w_v^2 s_des
    m_e x_e''    = -k_m x_e - c_m x_e' + k_p (s_act - x_e) + c_p (s_act' - x_e')             (7)
    f_act        = -k_m x_e - c_m x_e'                                                       (9)
    T_f f_mea' + f_mea = f_act                                                               (4)

At rest at the start, in equilibrium. Table 1, with a sensor lag of 10 ms.
"""

from __future__ import annotations

import math

import numpy as np
from scipy.linalg import expm

from tests.linear_blocks import Linear

m_s, T_f, s0 = 820.0, 0.01, -0.01
m_e, k_m, c_m, k_p, c_p = 80.0, 150e3, 158.0, 37.9e3, 65.0
gain, w_v, z = 30.0, 2.0 * math.pi * 20.0, 0.8
x_e0 = k_p / (k_m + k_p) * s0
f0 = -k_m * x_e0

AROUND = ["spacecraft", "motion_simulator", "contact", "force_sensor"]
S_DES, V_DES, S_ACT, V_ACT, A_ACT, X_E, DER_X_E, F_MEA = range(8)
SHOWN = {"spacecraft.s_des": S_DES, "motion_simulator.s_act": S_ACT}

# what each connection carries: (row of the derivative, column of the state) -> factor
WIRES = {
    ("force_sensor.f_mea", "spacecraft.f"): {(V_DES, F_MEA): 1 / m_s},
    ("spacecraft.s_des", "motion_simulator.s_cmd"): {(A_ACT, S_DES): gain * w_v**2},
    ("motion_simulator.s_act", "contact.s_act"): {(DER_X_E, S_ACT): k_p / m_e},
    ("motion_simulator.v_act", "contact.v_act"): {(DER_X_E, V_ACT): c_p / m_e},
    ("contact.f_act", "force_sensor.f_act"): {(F_MEA, X_E): -k_m / T_f, (F_MEA, DER_X_E): -c_m / T_f},
}
WITHIN = {
    (S_DES, V_DES): 1.0,
    **{(S_ACT, V_ACT): 1.0, (V_ACT, A_ACT): 1.0},
    **{(A_ACT, S_ACT): -gain * w_v**2, (A_ACT, V_ACT): -(w_v**2), (A_ACT, A_ACT): -2 * z * w_v},
    **{(X_E, DER_X_E): 1.0, (DER_X_E, X_E): -(k_m + k_p) / m_e, (DER_X_E, DER_X_E): -(c_m + c_p) / m_e},
    (F_MEA, F_MEA): -1 / T_f,
}
START = np.array([s0, 0.0, s0, 0.0, 0.0, x_e0, 0.0, f0])


def matrix(entries):
    """Matrix, shape (8, 8), of given entries."""
    made = np.zeros((8, 8))
    for place, factor in entries.items():
        made[place] = factor
    return made


WHOLE = matrix(WITHIN) + sum(matrix(entries) for entries in WIRES.values())


def orbit(generator, start, step, n):
    """States of x' = generator x at the times k step, shape (n + 1, states)."""
    tick, states = expm(generator * step), [start]
    for _ in range(n):
        states.append(tick @ states[-1])
    return np.array(states)


def exact_blocks():
    """The four subsystems as blocks that are exact for inputs that are linear in a step."""
    simulator = [[0, 1, 0], [0, 0, 1], [-gain * w_v**2, -(w_v**2), -2 * z * w_v]]
    mass = [[0, 1], [-(k_m + k_p) / m_e, -(c_m + c_p) / m_e]]
    f_act = {"f_act": ([-k_m, -c_m], [0, 0])}
    made = {
        "spacecraft": Linear([[0, 1], [0, 0]], [[0], [1 / m_s]], ("s_des", "v_des"), ("f",)),
        "motion_simulator": Linear(
            simulator, [[0], [0], [gain * w_v**2]], ("s_act", "v_act", "a_act"), ("s_cmd",)
        ),
        "contact": Linear(
            mass, [[0, 0], [k_p / m_e, c_p / m_e]], ("x_e", "der_x_e"), ("s_act", "v_act"), f_act
        ),
        "force_sensor": Linear([[-1 / T_f]], [[1 / T_f]], ("f_mea",), ("f_act",)),
    }
    return {name: linear.block() for name, linear in made.items()}


EXACT_START = {
    "spacecraft": {"s_des": s0},
    "motion_simulator": {"s_act": s0},
    "contact": {"x_e": x_e0},
    "force_sensor": {"f_mea": f0},
}


def fmus(step, integrator):
    """The project's FMUs, sampled once a step, as in a YAML file."""
    sampled = {"sample_time": step}
    contact = {"m_e": m_e, "k_m": k_m, "c_m": c_m, "k_p": k_p, "c_p": c_p}
    ship = {"m_s": m_s, "integrator": integrator, **sampled}
    simulator = {"K_p": gain, "w_v": w_v, "z": z, "dead_time": 0.0, **sampled}
    return {
        "spacecraft": {"source": "spacecraft", "parameters": ship, "start": {"s_des": s0}},
        "motion_simulator": {
            "source": "motion_simulator_linear",
            "parameters": simulator,
            "start": {"s_act": s0},
        },
        "contact": {"source": "docking_contact", "parameters": contact},
        "force_sensor": {"source": "force_sensor", "parameters": {"T_f": T_f, "sigma": 0.0, **sampled}},
    }


ITERATED = [{"iterate": AROUND, "tolerance": 1e-11, "maximum": 200}]
ORDERS = {
    **{f"from {name}": AROUND[i:] + AROUND[:i] for i, name in enumerate(AROUND)},
    "against the loop": AROUND[::-1],
    "side by side": [AROUND],
    "iterated": ITERATED,
}
SCHEMES = [(name, extrapolation) for name in list(ORDERS)[:-1] for extrapolation in (0, 1, 2)] + [
    ("iterated", 0)
]


def connections(order, extrapolation):
    """Connections with those extrapolated whose value would be old."""
    made = []
    for source, target in WIRES:
        ends = [end.partition(".")[0] for end in (source, target)]
        more = {"extrapolation": extrapolation} if _is_old(order, *ends) else {}
        made.append({"from": source, "to": target, **more})
    return made


def _is_old(order, source, target):
    if order == ITERATED:
        return False
    return order == [AROUND] or order.index(source) > order.index(target)

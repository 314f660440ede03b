"""
Reference experiment of the hexapod: MuJoCo's mechanics, the equations of the drives, an adaptive integrator.

The exact solution to ten digits. The model cuts a period into two steps of Runge-Kutta, which cannot follow
the 0.5 ms of the motor's electrics as closely.
"""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

from tests.fmu_sources.motion_simulator.mujoco_hexapod import Oracle
from tests.oracles.reference_experiment import Experiment, time_grid

T = 1e-3
N_STEPS = 250
TIME = time_grid(N_STEPS, T)
PARAMETERS = {"m_p": 460.0, "Kpp": 28.0, "dead_time": 0.003, "s_act": -0.01}
DEAD_PERIODS = 3
BASE_ANGLES = (12, 108, 132, 228, 252, 348)
PLATFORM_ANGLES = (48, 72, 168, 192, 288, 312)
HEIGHT = 1.35
MECHANICS = SimpleNamespace(
    **{"m_p": PARAMETERS["m_p"], "c_p": 0.12, "I_x": 75.0, "I_y": 75.0, "I_z": 120.0, "g": 9.81},
    **{"m_1": 45.0, "c_1": 0.40, "I_1": 6.0, "m_2": 18.0, "c_2": 0.40, "I_2": 2.2},
)
K2 = 2 * np.pi / 0.020
J, B, KT, KE, L, R_A = 3e-3, 4e-3, 0.55, 0.55, 4e-3, 0.45
KVP, KVI, KC = 1.2, 25.0, 8.0


def ring(radius: float, degrees: tuple[int, ...]) -> np.ndarray:
    """Joints on a circle, shape (6, 2) [m]."""
    angles = np.radians(degrees)
    return radius * np.column_stack([np.cos(angles), np.sin(angles)])


BASE, JOINTS = ring(1.10, BASE_ANGLES), ring(0.75, PLATFORM_ANGLES)


def experiment() -> Experiment:
    """Give the motion under commands in three coordinates, a contact force and a side load."""
    inputs = stimuli()
    return Experiment("motion_simulator", TIME, PARAMETERS, inputs, answers(inputs))


def stimuli() -> dict[str, np.ndarray]:
    """Make commands that start at rest, and loads."""
    rows = {f"{name}[{i}]": np.zeros_like(TIME) for name in ("pose_cmd", "wrench") for i in range(1, 7)}
    rows["pose_cmd[1]"] = 0.003 * (1 - np.cos(2 * np.pi * 1.5 * TIME))
    rows["pose_cmd[5]"] = 0.004 * (1 - np.cos(2 * np.pi * 2.0 * TIME))
    rows["wrench[2]"] = 80.0 * np.sin(2 * np.pi * 3.0 * TIME)
    rows["s_cmd"] = -0.01 * np.cos(2 * np.pi * 1.0 * TIME)
    rows["f_contact"] = 300.0 * np.cos(2 * np.pi * 1.0 * TIME)
    return {name: np.round(row, 9) for name, row in rows.items()}


def legs(centre: np.ndarray, R: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Lengths [m], shape (6,), and their rates by twist of the platform, shape (6, 6)."""
    levers = np.column_stack([JOINTS, np.zeros(6)]) @ R.T
    d = centre + levers - np.column_stack([BASE, np.zeros(6)])
    lengths = np.linalg.norm(d, axis=1)
    n = d / lengths[:, None]
    return lengths, np.column_stack([n, np.cross(levers, n)])


def place(pose: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Joint centre and rotation of a pose (x, y, z, roll, pitch, yaw) from the neutral one."""
    return pose[:3] + np.array([0, 0, HEIGHT]), Rotation.from_euler("xyz", pose[3:]).as_matrix()


def answers(inputs: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
    """Integrate period by period, all inputs held."""
    mechanism = Oracle(MECHANICS, BASE, JOINTS, J * K2 * K2)
    commands = np.column_stack([inputs[f"pose_cmd[{i}]"] for i in range(1, 7)])
    commands[:, 2] += inputs["s_cmd"]
    wrenches = np.column_stack([inputs[f"wrench[{i}]"] for i in range(1, 7)])
    wrenches[:, 2] += inputs["f_contact"]
    start = np.array([0, 0, PARAMETERS["s_act"], 0, 0, 0])
    late = np.vstack([np.tile(start, (DEAD_PERIODS, 1)), commands])
    x = steady(mechanism, start, wrenches[0])
    rows = [x]
    for wrench, command in zip(wrenches[:-1], late, strict=False):
        reference = legs(*place(command))[0]
        course = solve_ivp(
            lambda t, x, *u: rates(mechanism, x, *u),
            (0, T),
            rows[-1],
            method="DOP853",
            rtol=1e-10,
            atol=1e-12,
            args=(reference, wrench),
        )
        rows.append(course.y[:, -1])
    return outputs(np.array(rows))


def steady(mechanism: Oracle, pose: np.ndarray, wrench: np.ndarray) -> np.ndarray:
    """States at rest under the load: the leg forces that leave no acceleration, and their currents."""
    centre, R = place(pose)
    rest = mechanism.accelerations(centre, R, np.zeros(6), np.zeros(6), wrench)
    unit = [mechanism.accelerations(centre, R, np.zeros(6), f, wrench) - rest for f in np.eye(6)]
    currents = np.linalg.solve(np.transpose(unit), -rest) / (K2 * KT)
    return np.concatenate([pose, np.zeros(6), currents, (R_A / KC + 1) * currents / KVI])


def rates(mechanism: Oracle, x: np.ndarray, reference: np.ndarray, wrench: np.ndarray) -> np.ndarray:
    """Derivatives of pose, twist, currents and integrals of the speed errors."""
    pose, twist, i, z = np.split(x, 4)
    centre, R = place(pose)
    lengths, by_twist = legs(centre, R)
    om = K2 * (by_twist @ twist)
    e_v = K2 * PARAMETERS["Kpp"] * (reference - lengths) - om
    V = KC * (KVP * e_v + KVI * z - i)
    nu = mechanism.accelerations(centre, R, twist, K2 * (KT * i - B * om), wrench)
    return np.concatenate([twist[:3], angle_rates(pose, twist[3:]), nu, (V - R_A * i - KE * om) / L, e_v])


def angle_rates(pose: np.ndarray, omega: np.ndarray) -> np.ndarray:
    """Rates of roll, pitch, yaw: omega = yaw' e_z + R_z pitch' e_y + R_z R_y roll' e_x."""
    _, pitch, yaw = pose[3:]
    Rz = Rotation.from_euler("z", yaw).as_matrix()
    Ry = Rotation.from_euler("y", pitch).as_matrix()
    return np.linalg.solve(np.column_stack([Rz @ Ry @ [1, 0, 0], Rz @ [0, 1, 0], [0, 0, 1]]), omega)


def outputs(x: np.ndarray) -> dict[str, np.ndarray]:
    """Choose what the CSV holds: motion along the axes that are commanded, and one leg."""
    names = {"x_act": 0, "y_act": 1, "s_act": 2, "pitch_act": 4, "v_act": 8, "wy_act": 10}
    lengths = np.array([legs(*place(row[:6]))[0] for row in x])
    return {name: x[:, i] for name, i in names.items()} | {"leg_length[1]": lengths[:, 0]}

"""The hexapod as a MuJoCo tree (six legs and a free platform), its loops closed exactly by hand."""

from __future__ import annotations

from typing import Any

import mujoco
import numpy as np

AXIAL_INERTIA = 1e-9


def build(p: Any, base: np.ndarray, joints: np.ndarray, rotor: float) -> mujoco.MjModel:
    """Compile the tree: joints of base and platform, shape (6, 2) [m], reflected mass of a motor [kg]."""
    legs = "".join(_leg(i, p, b, rotor) for i, b in enumerate(base))
    sites = "".join(f'<site name="a{i}" pos="{x!r} {y!r} 0"/>' for i, (x, y) in enumerate(joints.tolist()))
    return mujoco.MjModel.from_xml_string(f"""
        <mujoco><compiler angle="radian" balanceinertia="false" boundmass="0" boundinertia="0"/>
          <option gravity="0 0 -{p.g!r}"><flag contact="disable"/></option>
          <worldbody>{legs}
            <body name="platform"><freejoint/>
              <inertial pos="0 0 {p.c_p!r}" mass="{p.m_p!r}" diaginertia="{p.I_x!r} {p.I_y!r} {p.I_z!r}"/>
              {sites}
            </body>
          </worldbody></mujoco>""")


def _leg(i: int, p: Any, base: np.ndarray, rotor: float) -> str:
    x, y = base.tolist()
    cylinder, rod = (f"{inertia!r} {inertia!r} {AXIAL_INERTIA!r}" for inertia in (p.I_1, p.I_2))
    return f"""
        <body name="cylinder{i}" pos="{x!r} {y!r} 0">
          <joint type="hinge" axis="1 0 0"/><joint type="hinge" axis="0 1 0"/>
          <inertial pos="0 0 {p.c_1!r}" mass="{p.m_1!r}" diaginertia="{cylinder}"/>
          <body name="rod{i}"><joint name="slide{i}" type="slide" axis="0 0 1" armature="{rotor!r}"/>
            <inertial pos="0 0 {-p.c_2!r}" mass="{p.m_2!r}" diaginertia="{rod}"/>
            <site name="e{i}" pos="0 0 0"/>
          </body>
        </body>"""


class Oracle:
    """Accelerations of the closed mechanism from MuJoCo's mass matrix, bias forces and Jacobians."""

    def __init__(self, p: Any, base: np.ndarray, joints: np.ndarray, rotor: float) -> None:
        self.model = build(p, base, joints, rotor)
        self.data = mujoco.MjData(self.model)
        self.base, self.joints = base, joints

    def accelerations(
        self, p: np.ndarray, R: np.ndarray, twist: np.ndarray, forces: np.ndarray, wrench: np.ndarray
    ) -> np.ndarray:
        """
        Accelerations of the platform's joint centre and its angular acceleration in base axes, shape (6,).

        Args:
            p: Joint centre of the platform [m].
            R: Rotation of the platform.
            twist: Velocity and angular velocity, base axes.
            forces: Along the legs [N].
            wrench: Force and torque at the joint centre, base axes.
        """
        self._place(p, R, twist)
        J, J_dot_v = self._closure()
        n = self.model.nv
        M = np.zeros((n, n))
        for row, unit in zip(M, np.eye(n), strict=True):
            mujoco.mj_mulM(self.model, self.data, row, unit)
        applied = np.zeros(n)
        applied[2:18:3] = forces
        applied[18:21], applied[21:] = wrench[:3], R.T @ wrench[3:]
        system = np.block([[M, J.T], [J, np.zeros((18, 18))]])
        rest = np.concatenate([applied - self.data.qfrc_bias, -J_dot_v])
        scale = 1 / np.sqrt(np.concatenate([np.diag(M), np.ones(18)]))
        solution = scale * np.linalg.solve(system * np.outer(scale, scale), rest * scale)
        return np.concatenate([solution[18:21], R @ solution[21:24]])

    def _place(self, p: np.ndarray, R: np.ndarray, twist: np.ndarray) -> None:
        model, data = self.model, self.data
        for i, (b, a) in enumerate(zip(self.base, self.joints, strict=True)):
            lever = R @ [*a, 0.0]
            d = p + lever - [*b, 0.0]
            length = np.linalg.norm(d)
            # the hinges turn the leg's axis to R_x(alpha) R_y(beta) e_z
            alpha, beta = np.arctan2(-d[1], d[2]), np.arcsin(d[0] / length)
            data.qpos[3 * i : 3 * i + 3] = alpha, beta, length
        quaternion = np.zeros(4)
        mujoco.mju_mat2Quat(quaternion, R.flatten())
        data.qpos[18:21], data.qpos[21:25] = p, quaternion
        data.qvel[:] = 0.0
        mujoco.mj_forward(model, data)
        platform = np.concatenate([twist[:3], R.T @ twist[3:]])
        J, _ = self._closure()
        data.qvel[:18] = np.linalg.solve(J[:, :18], -J[:, 18:] @ platform)
        data.qvel[18:] = platform
        mujoco.mj_forward(model, data)

    def _closure(self) -> tuple[np.ndarray, np.ndarray]:
        """Jacobian of the 18 closure conditions, and its rate times the velocity."""
        rows, rates = [], []
        for i in range(6):
            ends = [self._site(f"{kind}{i}") for kind in ("e", "a")]
            rows.append(ends[0][0] - ends[1][0])
            rates.append((ends[0][1] - ends[1][1]) @ self.data.qvel)
        return np.vstack(rows), np.concatenate(rates)

    def _site(self, name: str) -> tuple[np.ndarray, np.ndarray]:
        model, data = self.model, self.data
        site = model.site(name)
        jacobian, rate = np.zeros((3, model.nv)), np.zeros((3, model.nv))
        point, body = data.site_xpos[site.id], int(model.site_bodyid[site.id])
        mujoco.mj_jac(model, data, jacobian, None, point, body)
        mujoco.mj_jacDot(model, data, rate, None, point, body)
        return jacobian, rate

"""
Motion of the platform on its six legs.

    M_s(q) nu' + C_s(q, nu) nu + G_s(q) = J_lq^T f_a + wrench

`mechanics` evaluates the legs at a pose and twist, `accelerations` solves for nu', `holding_forces` for the
forces of the legs that keep it at rest:

    J_lq^T f = -W,   f = -(J_lq J_lq^T)^-1 J_lq W         W = weight of platform and legs + wrench
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

from ..framework.arithmetic import Arithmetic
from .geometry import Attitude, Leg, Vector, attitude, legs
from .inertia import (
    LegMotion,
    PointMass,
    leg_motion,
    mass_matrix,
    platform_force,
    platform_inertia,
    platform_mass,
    resultant,
)
from .solve import solve


class Mechanics(NamedTuple):
    """Platform and legs at one pose and twist."""

    R: Attitude
    omega: Vector
    legs: list[Leg]
    motions: list[LegMotion]


def mechanics(pose: Sequence[Any], twist: Sequence[Any], p: Any, m: Arithmetic) -> Mechanics:
    """
    Evaluate geometry and velocity terms.

    Args:
        pose: x, y, z [m] from the neutral pose, roll, pitch, yaw [rad].
        twist: Velocity [m/s] of the platform's joint centre and angular velocity [rad/s], base axes.
        p: Parameters.
        m: Arithmetic.
    """
    x, y, z, roll, pitch, yaw = pose
    vx, vy, vz, wx, wy, wz = twist
    v, omega = (vx, vy, vz), (wx, wy, wz)
    R = attitude(roll, pitch, yaw, m)
    six = legs((x, y, z), R, p, m)
    return Mechanics(R, omega, six, [leg_motion(leg, v, omega, p) for leg in six])


def accelerations(
    at: Mechanics, forces: Sequence[Any], wrench: Sequence[Any], rotor: Any, p: Any
) -> list[Any]:
    """
    Acceleration nu' of the platform's joint centre [m/s^2] and angular acceleration [rad/s^2].

    Args:
        at: Platform and legs.
        forces: Along each leg, positive where it lengthens, shape (6,) [N].
        wrench: Outer force [N] and torque about the joint centre [N m], shape (6,).
        rotor: Rotor inertia as a mass along each leg, J K2^2 [kg].
        p: Parameters.
    """
    inertia = platform_inertia(at.R, p)
    along = [f - rotor * motion.stretch for f, motion in zip(forces, at.motions, strict=True)]
    load = _load(at, along, inertia, p)
    body = platform_mass(at.R, p)
    masses = [body, *(PointMass(motion.mu, leg.r) for leg, motion in zip(at.legs, at.motions, strict=True))]
    kappa = [p.m_2 + rotor - motion.mu for motion in at.motions]
    M_s = mass_matrix(at.legs, masses, inertia, kappa)
    return solve(M_s, [a + b for a, b in zip(load, wrench, strict=True)])


def leg_acceleration(leg: Leg, motion: LegMotion, nu: Sequence[Any]) -> Any:
    """Give l'' [m/s^2] from the accelerations nu' of the platform."""
    (nx, ny, nz), (ax, ay, az) = leg.n, leg.arm
    x, y, z, rx, ry, rz = nu
    return nx * x + ny * y + nz * z + ax * rx + ay * ry + az * rz + motion.stretch


def holding_forces(at: Mechanics, wrench: Sequence[Any], p: Any) -> list[Any]:
    """Forces along the legs [N] that keep platform and legs at rest, shape (6,)."""
    load = _load(at, [0.0] * 6, platform_inertia(at.R, p), p)
    W = [a + b for a, b in zip(load, wrench, strict=True)]
    J = [leg.n + leg.arm for leg in at.legs]
    squares = [[_dot(row, other) for other in J[: i + 1]] for i, row in enumerate(J)]
    return solve(squares, [-_dot(row, W) for row in J])


def _load(at: Mechanics, along: Sequence[Any], inertia: Sequence[Any], p: Any) -> list[Any]:
    body = platform_mass(at.R, p)
    force, torque = platform_force(body, inertia, at.omega, p)
    points = [(body.r, force)]
    for leg, motion, f in zip(at.legs, at.motions, along, strict=True):
        (nx, ny, nz), (fx, fy, fz) = leg.n, motion.force
        points.append((leg.r, (fx + f * nx, fy + f * ny, fz + f * nz)))
    x, y, z, rx, ry, rz = resultant(points)
    return [x, y, z, rx + torque[0], ry + torque[1], rz + torque[2]]


def _dot(a: Sequence[Any], b: Sequence[Any]) -> Any:
    (a1, a2, a3, a4, a5, a6), (b1, b2, b3, b4, b5, b6) = a, b
    return a1 * b1 + a2 * b2 + a3 * b3 + a4 * b4 + a5 * b5 + a6 * b6

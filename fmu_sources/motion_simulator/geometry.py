"""
Where the joints are, and the inverse kinematics: from the pose of the platform to its six legs.

    R   = R_z(yaw) R_y(pitch) R_x(roll)
    r_i = R a_i
    l_i n_i = p + r_i - b_i                p = (x, y, height + z)
    J_lq,i  = [n_i, r_i x n_i]             der(l_i) = J_lq,i (v, omega)

Base joints stand in pairs around 0, 120 and 240 deg, platform joints around 60, 180 and 300 deg; leg i goes
from base joint i (12, 108, 132, 228, 252, 348 deg) to platform joint i (48, 72, 168, 192, 288, 312 deg).
"""

from __future__ import annotations

from typing import Any, NamedTuple

from ..framework.arithmetic import Arithmetic

Vector = tuple[Any, Any, Any]

SIN_60 = 0.8660254037844386
TINY = 1e-300  # keeps a leg of length zero from dividing by zero; far below the rounding of a real one


class Attitude(NamedTuple):
    """Columns of R, and what the rates of the angles need."""

    x: Vector
    y: Vector
    z: Vector
    sin_pitch: Any
    cos_pitch: Any
    sin_yaw: Any
    cos_yaw: Any


class Leg(NamedTuple):
    """Lever r = R a [m], unit vector n, moment arm r x n [m], length l [m], and 1/l."""

    r: Vector
    n: Vector
    arm: Vector
    l: Any  # noqa: E741
    per_l: Any


def attitude(roll: Any, pitch: Any, yaw: Any, m: Arithmetic) -> Attitude:
    """Rotation of the platform: about x by roll, then y by pitch, then z by yaw, axes of the base."""
    sr, cr = m.sin(roll), m.cos(roll)
    sp, cp = m.sin(pitch), m.cos(pitch)
    sy, cy = m.sin(yaw), m.cos(yaw)
    cy_sp, sy_sp = cy * sp, sy * sp
    return Attitude(
        (cy * cp, sy * cp, -sp),
        (cy_sp * sr - sy * cr, sy_sp * sr + cy * cr, cp * sr),
        (cy_sp * cr + sy * sr, sy_sp * cr - cy * sr, cp * cr),
        sp,
        cp,
        sy,
        cy,
    )


def angle_rates(attitude: Attitude, omega: Vector) -> Vector:
    """Rates of roll, pitch and yaw [rad/s] from the angular velocity [rad/s] in base axes."""
    wx, wy, wz = omega
    roll = (attitude.cos_yaw * wx + attitude.sin_yaw * wy) / attitude.cos_pitch
    pitch = attitude.cos_yaw * wy - attitude.sin_yaw * wx
    return roll, pitch, wz + attitude.sin_pitch * roll


def ring(radius: Any, angle: Any, m: Arithmetic) -> list[tuple[Any, Any]]:
    """Place joints at +angle, 120 deg -+ angle, 240 deg -+ angle, -angle [rad] on a circle [m]."""
    c, s = radius * m.cos(angle), radius * m.sin(angle)
    half_c, half_s, high_c, high_s = 0.5 * c, 0.5 * s, SIN_60 * c, SIN_60 * s
    one = (c, s)
    two = (high_s - half_c, high_c + half_s)
    three = (-half_c - high_s, high_c - half_s)
    return [one, two, three, (three[0], -three[1]), (two[0], -two[1]), (one[0], -one[1])]


def base_joints(p: Any, m: Arithmetic) -> list[tuple[Any, Any]]:
    """Joints b_i in the plane of the base [m]."""
    return ring(p.base_radius, p.base_half_angle, m)


def platform_joints(p: Any, m: Arithmetic) -> list[tuple[Any, Any]]:
    """Joints a_i in the plane of the platform [m]."""
    return ring(p.platform_radius, m.pi / 3.0 - p.platform_half_angle, m)


def legs(position: Vector, attitude: Attitude, p: Any, m: Arithmetic) -> list[Leg]:
    """Inverse kinematics: the six legs at a position relative to the neutral one [m]."""
    joints = zip(base_joints(p, m), platform_joints(p, m), strict=True)
    centre = (position[0], position[1], p.height + position[2])
    return [_leg(centre, attitude, b, a, m) for b, a in joints]


def leg_lengths(pose: Any, p: Any, m: Arithmetic) -> tuple[Any, ...]:
    """Lengths [m] at a pose (x, y, z, roll, pitch, yaw) relative to the neutral one."""
    x, y, z, roll, pitch, yaw = pose
    return tuple(leg.l for leg in legs((x, y, z), attitude(roll, pitch, yaw, m), p, m))


def _leg(
    centre: Vector, attitude: Attitude, base: tuple[Any, Any], joint: tuple[Any, Any], m: Arithmetic
) -> Leg:
    ax, ay = joint
    (xx, xy, xz), (yx, yy, yz) = attitude.x, attitude.y
    rx, ry, rz = xx * ax + yx * ay, xy * ax + yy * ay, xz * ax + yz * ay
    dx, dy, dz = centre[0] + rx - base[0], centre[1] + ry - base[1], centre[2] + rz
    length = m.sqrt(dx * dx + dy * dy + dz * dz + TINY)
    per_l = 1.0 / length
    nx, ny, nz = dx * per_l, dy * per_l, dz * per_l
    arm = (ry * nz - rz * ny, rz * nx - rx * nz, rx * ny - ry * nx)
    return Leg((rx, ry, rz), (nx, ny, nz), arm, length, per_l)

"""
Mass matrix of the platform with its legs, and the forces of their motion and weight.

A leg is a cylinder (m_1, I_1, centre of mass c_1 from the base joint) and a rod (m_2, I_2, c_2 from the
platform joint) on one line; I is its moment of inertia about the base joint. With v_a = v + omega x r the
velocity of its platform joint, u = n.v_a, w = v_a - u n, b = omega x (omega x r), J_a = [1, -r~], e_z up:

    I    = I_1 + m_1 c_1^2 + I_2 + m_2 (l - c_2)^2,   mu = I / l^2
    M_i  = mu 1 + (m_2 - mu) n n^T
    h_i  = n (m_2 |w|^2/l - m_2 (l - c_2) |w|^2/l^2) + (2 u/l) (m_2 (l - c_2)/l - mu) w
    g_i  = m_2 g e_z + (m_1 c_1 - m_2 c_2) g (1 - n n^T) e_z / l
    l''  = J_lq,i nu' + n.b + |w|^2/l

    M_s  = M_p + sum J_a^T M_i J_a + J K2^2 J_lq,i^T J_lq,i        nu = (v, omega)
    M_s nu' = wrench - bias_p + sum J_a^T (n (f - J K2^2 (n.b + |w|^2/l)) - M_i b - h_i - g_i)

Since J_a^T n = J_lq,i, every leg is a point mass mu at r and a rank-one term.
Source: principle of virtual work, equal to Kane's equations; paper, Sec. III-D (M_s, C_s, G_s).
Neglected: spin of a leg about its axis.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

from .geometry import Attitude, Leg, Vector


class LegMotion(NamedTuple):
    """What a leg's motion gives: mu [kg], der(l) [m/s], l'' - J_lq nu' [m/s^2], force on its joint [N]."""

    mu: Any
    der_l: Any
    stretch: Any
    force: Vector


class PointMass(NamedTuple):
    """A mass [kg] at a lever from the platform's joint centre [m]."""

    mass: Any
    r: Vector


def cross(a: Vector, b: Vector) -> Vector:
    """Vector product."""
    ax, ay, az = a
    bx, by, bz = b
    return ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx


def leg_motion(leg: Leg, v: Vector, omega: Vector, p: Any) -> LegMotion:
    """Velocity terms and weight of one leg."""
    nx, ny, nz = leg.n
    spin = cross(omega, leg.r)
    ax, ay, az = v[0] + spin[0], v[1] + spin[1], v[2] + spin[2]
    u = nx * ax + ny * ay + nz * az
    wx, wy, wz = ax - u * nx, ay - u * ny, az - u * nz
    bx, by, bz = cross(omega, spin)
    n_b = nx * bx + ny * by + nz * bz
    w2 = (wx * wx + wy * wy + wz * wz) * leg.per_l
    arm = leg.l - p.c_2
    moment = p.m_2 * arm * leg.per_l
    mu = (p.I_1 + p.m_1 * p.c_1 * p.c_1 + p.I_2 + p.m_2 * arm * arm) * leg.per_l * leg.per_l
    stretch = n_b + w2
    weight = (p.m_1 * p.c_1 - p.m_2 * p.c_2) * p.g * leg.per_l
    along = weight * nz + mu * n_b + moment * w2 - p.m_2 * stretch
    across = 2.0 * u * leg.per_l * (moment - mu)
    force = (
        along * nx - mu * bx - across * wx,
        along * ny - mu * by - across * wy,
        along * nz - mu * bz - across * wz - p.m_2 * p.g - weight,
    )
    return LegMotion(mu, u, stretch, force)


def platform_mass(R: Attitude, p: Any) -> PointMass:
    """Platform and adapter as a mass at their centre of mass."""
    x, y, z = R.z
    return PointMass(p.m_p, (p.c_p * x, p.c_p * y, p.c_p * z))


def platform_inertia(R: Attitude, p: Any) -> tuple[Any, ...]:
    """Inertia about the centre of mass in base axes: xx, xy, yy, xz, yz, zz [kg m^2]."""
    axes = zip((p.I_x, p.I_y, p.I_z), R[:3], strict=True)
    (ax, ay, az, x), (bx, by, bz, y), (cx, cy, cz, z) = ((i * a[0], i * a[1], i * a[2], a) for i, a in axes)
    return (
        ax * x[0] + bx * y[0] + cx * z[0],
        ax * x[1] + bx * y[1] + cx * z[1],
        ay * x[1] + by * y[1] + cy * z[1],
        ax * x[2] + bx * y[2] + cx * z[2],
        ay * x[2] + by * y[2] + cy * z[2],
        az * x[2] + bz * y[2] + cz * z[2],
    )


def platform_force(body: PointMass, inertia: Sequence[Any], omega: Vector, p: Any) -> tuple[Vector, Vector]:
    """Force on the platform's mass [N] and torque [N m] from its rotation and weight."""
    xx, xy, yy, xz, yz, zz = inertia
    ox, oy, oz = omega
    spin = (xx * ox + xy * oy + xz * oz, xy * ox + yy * oy + yz * oz, xz * ox + yz * oy + zz * oz)
    bx, by, bz = cross(omega, cross(omega, body.r))
    force = (-p.m_p * bx, -p.m_p * by, -p.m_p * (bz + p.g))
    return force, cross(spin, omega)


def mass_matrix(
    legs: Sequence[Leg], masses: Sequence[PointMass], inertia: Sequence[Any], kappa: Sequence[Any]
) -> list[list[Any]]:
    """
    Lower triangle of M_s, row i with i + 1 elements.

    Args:
        legs: The six legs.
        masses: Platform and legs as point masses.
        inertia: Of the platform, as `platform_inertia` gives it.
        kappa: Coefficient of J_lq,i^T J_lq,i, shape (6,) [kg].
    """
    xx, xy, yy, xz, yz, zz = inertia
    mass, px, py, pz = 0.0, 0.0, 0.0, 0.0
    for mu, (x, y, z) in masses:
        mx, my, mz = mu * x, mu * y, mu * z
        mass, px, py, pz = mass + mu, px + mx, py + my, pz + mz
        xx, yy, zz = xx + (my * y + mz * z), yy + (mx * x + mz * z), zz + (mx * x + my * y)
        xy, xz, yz = xy - mx * y, xz - mx * z, yz - my * z
    K = weighted_squares([leg.n + leg.arm for leg in legs], kappa)
    return [
        [K[0][0] + mass],
        [K[1][0], K[1][1] + mass],
        [K[2][0], K[2][1], K[2][2] + mass],
        [K[3][0], K[3][1] - pz, K[3][2] + py, K[3][3] + xx],
        [K[4][0] + pz, K[4][1], K[4][2] - px, K[4][3] + xy, K[4][4] + yy],
        [K[5][0] - py, K[5][1] + px, K[5][2], K[5][3] + xz, K[5][4] + yz, K[5][5] + zz],
    ]


def weighted_squares(rows: Sequence[Sequence[Any]], weights: Sequence[Any]) -> list[list[Any]]:
    """Lower triangle of sum_i w_i q_i^T q_i over six rows q_i."""
    columns = list(zip(*rows, strict=True))
    triangle = []
    for i, column in enumerate(columns):
        a, b, c, d, e, f = (w * q for w, q in zip(weights, column, strict=True))
        others = columns[: i + 1]
        triangle.append([a * o + b * q + c * r + d * s + e * t + f * u for o, q, r, s, t, u in others])
    return triangle


def resultant(points: Sequence[tuple[Vector, Vector]]) -> tuple[Any, ...]:
    """Sum of (r, force) pairs [m, N] as force and torque about the platform's joint centre, shape (6,)."""
    x, y, z, tx, ty, tz = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for (rx, ry, rz), (fx, fy, fz) in points:
        x, y, z = x + fx, y + fy, z + fz
        tx, ty, tz = tx + (ry * fz - rz * fy), ty + (rz * fx - rx * fz), tz + (rx * fy - ry * fx)
    return x, y, z, tx, ty, tz

from __future__ import annotations

import math

import numpy as np
import pytest

from fmu_sources.framework.arithmetic import PYTHON
from fmu_sources.motion_simulator.dynamics import mechanics
from fmu_sources.motion_simulator.geometry import (
    angle_rates,
    attitude,
    base_joints,
    leg_lengths,
    platform_joints,
)
from fmu_sources.motion_simulator.solve import solve
from tests.fmu_sources.motion_simulator.hexapod import NEUTRAL, PARAMETERS

POSE = (0.05, -0.08, 0.11, 0.2, -0.15, 0.3)
TWIST = (0.3, -0.2, 0.4, 0.5, 0.6, -0.7)


def on_circle(radius, degrees):
    return [(radius * math.cos(math.radians(d)), radius * math.sin(math.radians(d))) for d in degrees]


def test_joints_stand_in_pairs_on_their_circles():
    base, platform = base_joints(PARAMETERS, PYTHON), platform_joints(PARAMETERS, PYTHON)

    np.testing.assert_allclose(base, on_circle(1.10, (12, 108, 132, 228, 252, 348)), atol=1e-15)
    np.testing.assert_allclose(platform, on_circle(0.75, (48, 72, 168, 192, 288, 312)), atol=1e-15)


def test_neutral_legs_have_the_length_of_the_triangle():
    length = math.sqrt(1.35**2 + 1.1**2 + 0.75**2 - 2 * 1.1 * 0.75 * math.cos(math.radians(36)))

    assert leg_lengths(NEUTRAL, PARAMETERS, PYTHON) == pytest.approx([length] * 6, abs=1e-15)


def test_neutral_pose_is_as_published():
    legs = mechanics(NEUTRAL, NEUTRAL, PARAMETERS, PYTHON).legs

    assert legs[0].n[2] == pytest.approx(0.898, abs=5e-4)
    assert np.linalg.cond([leg.n + leg.arm for leg in legs]) == pytest.approx(3.0, abs=0.05)


@pytest.mark.parametrize(
    ("angles", "turned"),
    [((0.3, 0, 0), [0, math.cos(0.3), math.sin(0.3)]), ((0, 0, 0.3), [-math.sin(0.3), math.cos(0.3), 0])],
)
def test_angles_turn_the_y_axis_by_the_right_hand_rule(angles, turned):
    assert attitude(*angles, PYTHON).y == pytest.approx(turned)


def test_roll_comes_first_and_yaw_last():
    R = np.column_stack(attitude(0.2, -0.15, 0.3, PYTHON)[:3])
    x, y, z = (np.column_stack(attitude(*angles, PYTHON)[:3]) for angles in np.diag([0.2, -0.15, 0.3]))

    np.testing.assert_allclose(R, z @ y @ x, atol=1e-15)


def moved(h):
    rates = angle_rates(attitude(*POSE[3:], PYTHON), TWIST[3:])
    return tuple(q + h * v for q, v in zip(POSE, (*TWIST[:3], *rates), strict=True))


def test_rates_of_the_angles_turn_the_platform_with_its_angular_velocity():
    h = 1e-5
    before, after = (np.column_stack(attitude(*moved(s)[3:], PYTHON)[:3]) for s in (-h, h))
    wx, wy, wz = TWIST[3:]
    spin = np.array([[0, -wz, wy], [wz, 0, -wx], [-wy, wx, 0]])
    R = np.column_stack(attitude(*POSE[3:], PYTHON)[:3])

    np.testing.assert_allclose((after - before) / (2 * h), spin @ R, atol=1e-9)


def test_rates_of_the_lengths_are_the_jacobian_times_the_twist():
    h = 1e-5
    before, after = (np.array(leg_lengths(moved(s), PARAMETERS, PYTHON)) for s in (-h, h))
    at = mechanics(POSE, TWIST, PARAMETERS, PYTHON)
    J_lq = np.array([leg.n + leg.arm for leg in at.legs])

    np.testing.assert_allclose(J_lq @ TWIST, (after - before) / (2 * h), atol=1e-9)
    np.testing.assert_allclose([motion.der_l for motion in at.motions], J_lq @ TWIST, atol=1e-14)


def test_solve_is_the_solution_of_the_whole_matrix():
    random = np.random.default_rng(3)
    root = random.normal(size=(6, 6))
    matrix, b = root @ root.T + 0.1 * np.eye(6), random.normal(size=6)
    triangle = [row[: i + 1].tolist() for i, row in enumerate(matrix)]

    np.testing.assert_allclose(solve(triangle, b.tolist()), np.linalg.solve(matrix, b), rtol=1e-10)

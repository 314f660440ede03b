"""Rigs against exact solutions of their equations, and their slots."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.linalg import expm
from scipy.optimize import brentq
from scipy.special import ellipk

from fmu_sources.composed.registry import load
from fmu_sources.effects.catalogue import candidates
from fmu_sources.export.dependencies import Label, LabelArithmetic
from fmu_sources.framework.instance import Instance

RIGS = (
    "ball_and_beam",
    "cylinder",
    "follower",
    "motor",
    "pendulum",
    "position_servo",
    "preloaded_specimen",
    "rotary_axis_driven",
    "rotary_axis_inverse",
    "thermal_body",
    "two_masses",
    "two_tanks",
)
STEP = 1e-3


def after(name: str, seconds: float, step: float = STEP, **values: float) -> Instance:
    """A rig after some time, with values of its variables at the start."""
    instance = Instance(load(name))
    for key, value in values.items():
        instance[key] = value
    instance.initialise()
    for k in range(round(seconds / step)):
        instance.step(k * step, step)
    return instance


def free(matrix, start, seconds):
    """Exact solution of x' = A x + b from (A, b) as one matrix."""
    return (expm(np.asarray(matrix) * seconds) @ np.append(start, 1.0))[:-1]


@pytest.mark.parametrize("name", RIGS)
def test_no_equation_branches_and_every_slot_has_an_effect_that_fits(name):
    model, m = load(name), LabelArithmetic()
    x, u, p = (
        kind.record([Label(frozenset({n})) for n in kind.names])
        for kind in (model.states, model.inputs, model.parameters)
    )
    t = Label(frozenset({"time"}))

    assert set(model.derivatives(t, x, u, p, m)) == set(model.continuous.fields)
    assert set(model.outputs(t, x, u, p, m)) >= {v.name for v in model.variables if v.role.name == "OUTPUT"}
    assert all(candidates(slot) for slot in model.slots)


def test_a_rotary_axis_reaches_its_final_speed_exponentially():
    rig = after("rotary_axis_driven", 1.0, torque=0.1)

    assert rig["der_phi"] == pytest.approx(5.0 * (1.0 - math.exp(-0.4)), rel=1e-9)
    assert rig["phi"] == pytest.approx(5.0 * (1.0 - (1.0 - math.exp(-0.4)) / 0.4), rel=1e-9)


def test_the_inverse_of_a_rotary_axis_gives_the_torque_of_its_motion():
    rig = after("rotary_axis_inverse", 0.0, der_phi=3.0, der_der_phi=-2.0)

    assert rig["torque"] == pytest.approx(0.05 * -2.0 + 0.02 * 3.0, rel=1e-12)


def test_a_cylinder_is_driven_by_the_difference_of_its_forces():
    rig = after("cylinder", 0.1, p_1=5e5, p_2=2e5, load=62.0)
    final = (8e-4 * 5e5 - 6.9e-4 * 2e5 - 62.0) / 100.0  # 2 m/s

    assert final == pytest.approx(2.0)
    assert rig["der_q"] == pytest.approx(final * (1.0 - math.exp(-100.0 / 5.0 * 0.1)), rel=1e-7)


def test_a_follower_follows_a_step_with_gain_lag_and_offset():
    rig = after("follower", 0.2, gain=3.0, offset=-1.0, u=2.0)

    assert rig["z"] == pytest.approx(-1.0 + 6.0 * (1.0 - math.exp(-2.0)), rel=1e-9)


def test_a_position_servo_rests_where_its_torque_holds_the_weight():
    rig = after("position_servo", 3.0, phi_ref=1.0)
    held = brentq(lambda phi: 0.8 / 2.0 * 30.0 * (1.0 - phi) - 0.5 * math.sin(phi), 0.0, 1.0)

    assert rig["phi"] == pytest.approx(held, abs=1e-9)


def test_a_position_servo_without_weight_moves_as_its_matrix_says():
    rig = after("position_servo", 0.3, phi_ref=0.2, weight_moment=0.0)
    drive = 0.8 * 30.0 / 2.0 / 0.02
    loss = (0.8 * 0.8 / 2.0 + 0.05) / 0.02
    phi, der_phi = free([[0, 1, 0], [-drive, -loss, drive * 0.2], [0, 0, 0]], [0.0, 0.0], 0.3)

    assert (rig["phi"], rig["der_phi"]) == (pytest.approx(phi, rel=1e-6), pytest.approx(der_phi, abs=1e-6))


def test_tanks_drain_as_two_lags_in_a_row():
    rig = after("two_tanks", 100.0, step=0.1, h_1=0.2, h_2=0.1)
    rate, t = 0.01, 100.0  # r/A, equal for both

    assert rig["h_1"] == pytest.approx(0.2 * math.exp(-rate * t), rel=1e-9)
    assert rig["h_2"] == pytest.approx((0.1 + 0.2 * rate * t) * math.exp(-rate * t), rel=1e-9)


def test_a_motor_answers_a_step_of_voltage_as_its_matrix_says():
    rig = after("motor", 0.05, step=1e-4, voltage=6.0)
    matrix = [[-1.0 / 1e-3, -0.05 / 1e-3, 6.0 / 1e-3], [0.05 / 1e-4, -1e-5 / 1e-4, 0.0], [0.0, 0.0, 0.0]]
    current, speed = free(matrix, [0.0, 0.0], 0.05)

    assert (rig["current"], rig["der_phi"]) == (
        pytest.approx(current, rel=1e-5),
        pytest.approx(speed, rel=1e-6),
    )


def test_the_force_of_a_specimen_depends_on_its_control_signal():
    values = {"preload": 50.0, "damping_by_control": 400.0, "stiffness_by_control": -2e3}
    rig = after("preloaded_specimen", 0.0, x=0.01, der_x=-0.2, control=1.5, **values)

    assert rig["force"] == pytest.approx(50.0 + (1e4 - 3e3) * 0.01 - (1e3 + 600.0) * 0.2, rel=1e-12)


def test_two_masses_move_as_their_matrix_says():
    rig = after("two_masses", 0.25, force=30.0)
    k, c, d = 2e4, 20.0, 5.0
    matrix = [
        [0, 1, 0, 0, 0],
        [-k / 10, -(c + d) / 10, k / 10, c / 10, 3.0],
        [0, 0, 0, 1, 0],
        [k / 5, c / 5, -k / 5, -(c + d) / 5, 0],
        [0, 0, 0, 0, 0],
    ]
    expected = free(matrix, [0.0] * 4, 0.25)
    found = [rig[name] for name in ("q_1", "der_q_1", "q_2", "der_q_2")]

    assert found == pytest.approx(expected.tolist(), rel=2e-5)


def test_a_pendulum_swings_with_the_period_of_the_elliptic_integral():
    """From 2 rad at rest, back after T = 4 sqrt(J/(m g l)) K(sin(1)^2)."""
    period = 4.0 * math.sqrt(0.25 / 4.905) * float(ellipk(math.sin(1.0) ** 2))
    rig = after("pendulum", period, step=period / 2000, phi=2.0, damping=0.0)

    assert (rig["phi"], rig["der_phi"]) == (pytest.approx(2.0, abs=1e-7), pytest.approx(0.0, abs=1e-5))


def test_a_ball_rolls_down_a_beam_with_five_sevenths_of_gravity():
    rig = after("ball_and_beam", 0.4, theta=-0.1, damping=0.0)

    assert rig["q"] == pytest.approx(0.5 * 5.0 / 7.0 * 9.81 * math.sin(0.1) * 0.4**2, rel=1e-9)


def test_a_ball_on_a_turning_beam_leaves_its_middle_exponentially():
    rig = after("ball_and_beam", 0.5, q=0.01, der_theta=2.0, gravity=0.0, damping=0.0)

    assert rig["q"] == pytest.approx(0.01 * math.cosh(2.0 * math.sqrt(5.0 / 7.0) * 0.5), rel=1e-8)


def test_a_body_warms_up_exponentially():
    rig = after("thermal_body", 250.0, step=0.5, power=40.0)

    assert rig["temperature"] == pytest.approx(293.15 + 20.0 * (1.0 - math.exp(-1.0)), rel=1e-9)

"""Rigs against exact solutions of their equations."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.linalg import expm
from scipy.special import ellipk

from fmu_sources.composed.composition import with_effect
from fmu_sources.composed.registry import load
from fmu_sources.effects.catalogue import effect
from fmu_sources.framework.instance import Instance


def made(model, **values):
    """Initialise a model with parameters, inputs and states."""
    instance = Instance(load(model) if isinstance(model, str) else model)
    for name, value in values.items():
        instance[name] = value
    instance.initialise()
    return instance


def run(instance, seconds, h=1e-3):
    for k in range(round(seconds / h)):
        instance.step(k * h, h)
    return instance


def test_a_rotary_axis_reaches_its_final_speed_exponentially():
    axis = run(made("rotary_axis", i=2.0, inertia=0.02, damping=0.05, torque_constant=0.3), 0.5)

    assert axis["der_q"] == pytest.approx(0.3 * 2.0 / 0.05 * (1.0 - math.exp(-0.05 / 0.02 * 0.5)), rel=1e-9)


def test_a_rotary_axis_asks_for_the_torque_of_its_motion():
    axis = made("rotary_axis_inverse", der_q=3.0, der_der_q=-4.0, inertia=0.02, damping=0.05)

    assert axis["torque"] == pytest.approx(0.02 * -4.0 + 0.05 * 3.0)


def test_a_piston_moves_as_pressures_areas_and_load_push_it():
    piston = made("cylinder", p_a=4e5, p_b=1e5, load=50.0, area_a=2e-3, area_b=1e-3, mass=5.0, damping=80.0)
    run(piston, 0.1)

    push = 2e-3 * 4e5 - 1e-3 * 1e5 - 50.0
    assert piston["der_q"] == pytest.approx(push / 80.0 * (1.0 - math.exp(-80.0 / 5.0 * 0.1)), rel=1e-9)


def test_a_static_follower_is_a_straight_line():
    assert made("static_follower", u=3.0, gain=-2.0, zero=0.5)["y"] == pytest.approx(-5.5)


def test_a_moved_follower_passes_a_force_on_and_lets_friction_resist_on_its_side():
    """By hand: 2 times 3 and 0.5 pass; 20 N of friction against a force that drives, at full speed."""
    name = "moved_follower__resistance_coulomb"
    friction = {"resistance_coulomb_level": 20.0, "resistance_coulomb_smoothing": 1e-3}

    assert made("moved_follower", u=3.0, gain=2.0, zero=0.5)["y"] == pytest.approx(6.5)
    assert made(name, u=3.0, der_q=-0.1, side=-1.0, **friction)["y"] == pytest.approx(3.0 + 20.0)
    assert made(name, u=3.0, der_q=0.1, **friction)["y"] == pytest.approx(3.0 + 20.0)


def test_a_follower_of_first_order_is_exponential():
    follower = run(made("first_order_follower", u=2.0, gain=3.0, zero=-1.0, time_constant=0.2), 0.3)

    assert follower["y"] == pytest.approx(5.0 * (1.0 - math.exp(-0.3 / 0.2)), rel=1e-9)


@pytest.mark.parametrize("periods", [1, 7, 99])
def test_a_delayed_follower_gives_the_input_of_earlier(periods):
    follower = made("delayed_follower", dead_time=periods * 1e-3, gain=2.0, zero=1.0, u=0.0)
    found = []
    for k in range(150):
        follower["u"] = math.sin(k)
        follower.step(k * 1e-3, 1e-3)
        found.append(follower["y"])

    expected = [1.0 + 2.0 * (math.sin(k) if k >= 0 else 0.0) for k in range(1 - periods, 151 - periods)]
    assert found == pytest.approx(expected, abs=1e-12)


def test_a_servo_rests_where_its_torque_bears_the_load():
    servo = run(made("position_servo", q_ref=1.0, stiffness=5.0, gravity_torque=2.0, damping=1.0), 10.0)

    assert 5.0 * (1.0 - servo["q"]) == pytest.approx(2.0 * math.sin(servo["q"]), rel=1e-9)
    assert abs(servo["der_q"]) < 1e-9


def test_two_linear_tanks_fill_as_two_lags():
    k, u, c_1, r, c_2, t = 0.5, 2.0, 0.4, 1.5, 0.1, 8.0
    tanks = made("two_tanks", u=u, pump_gain=k, upper_rate=c_1, ratio=r, lower_rate=c_2)
    run(tanks, t, h=0.01)

    e_1, e_2 = math.exp(-c_1 * t), math.exp(-c_2 * t)
    assert tanks["h_1"] == pytest.approx(k * u / c_1 * (1.0 - e_1), rel=1e-9)
    assert tanks["h_2"] == pytest.approx(
        r * k * u * ((1.0 - e_2) / c_2 - (e_2 - e_1) / (c_1 - c_2)), rel=1e-9
    )


def test_a_tank_that_empties_by_the_square_root_has_a_straight_root():
    """The root of the level falls by C/2 a second, since h' = -C sqrt(h)."""
    model = with_effect(load("two_tanks"), "upper_outflow", effect("power_law"))
    tank = made(model, u=0.0, upper_rate=0.0, h_1=9.0, upper_outflow_power_law_amplitude=0.2)
    run(tank, 10.0, h=0.01)

    assert math.sqrt(tank["h_1"]) == pytest.approx(3.0 - 0.1 * 10.0, rel=1e-6)


def test_a_motor_is_its_linear_system():
    R, L, k, J, b, u, t = 2.0, 5e-3, 0.05, 2e-4, 1e-4, 6.0, 0.05
    motor = made("dc_motor", u=u, resistance=R, inductance=L, motor_constant=k, inertia=J, damping=b)
    run(motor, t, h=1e-4)

    A = np.array([[-R / L, -k / L], [k / J, -b / J]])
    exact = np.linalg.solve(A, (expm(A * t) - np.eye(2)) @ [u / L, 0.0])
    assert [motor["i"], motor["der_q"]] == pytest.approx(exact, rel=1e-6)


def test_a_controlled_damper_adds_preload_spring_and_controlled_damping():
    values = {"preload": 10.0, "stiffness": 100.0, "damping": 5.0, "controlled_damping": 2.0}
    damper = made("controlled_damper", x=0.1, der_x=-3.0, control=1.5, **values)

    assert damper["force"] == pytest.approx(10.0 + 10.0 + (5.0 + 3.0) * -3.0)


def test_two_masses_are_their_linear_system():
    m_1, m_2, k, c, b, f, t = 2.0, 3.0, 400.0, 2.0, 1.0, 5.0, 0.7
    given = {"mass_1": m_1, "mass_2": m_2, "stiffness": k, "coupling_damping": c, "damping": b}
    masses = run(made("two_masses", f=f, **given), t)

    A = np.array(
        [
            [0.0, 1.0, 0.0, 0.0, 0.0],
            [-k / m_1, -c / m_1, k / m_1, c / m_1, f / m_1],
            [0.0, 0.0, 0.0, 1.0, 0.0],
            [k / m_2, c / m_2, -k / m_2, -(c + b) / m_2, 0.0],
            [0.0, 0.0, 0.0, 0.0, 0.0],
        ]
    )
    exact = (expm(A * t) @ [0.0, 0.0, 0.0, 0.0, 1.0])[:4]
    assert [masses[n] for n in ("q_1", "der_q_1", "q_2", "der_q_2")] == pytest.approx(exact, rel=1e-7)


def test_a_pendulum_has_the_period_of_the_elliptic_integral():
    J, G, angle = 0.5, 3.0, 1.5
    pendulum = made("pendulum", inertia=J, gravity_torque=G, damping=0.0, q=angle)
    period = 4.0 * math.sqrt(J / G) * ellipk(math.sin(angle / 2.0) ** 2)
    run(pendulum, 1.0, h=period / 1000.0)  # 1000 steps a period: it ends within the first
    steps = round(1.0 / (period / 1000.0))
    for k in range(steps, 1000):
        pendulum.step(k * period / 1000.0, period / 1000.0)

    assert pendulum["q"] == pytest.approx(angle, abs=1e-6)
    assert abs(pendulum["der_q"]) < 1e-5


def test_a_ball_rolls_down_a_beam_with_five_sevenths_of_what_slides():
    ball = run(made("ball_and_beam", angle=0.1, gravity=9.8), 2.0)

    assert ball["q"] == pytest.approx(5.0 / 7.0 * 9.8 * math.sin(0.1) * 2.0**2 / 2.0, rel=1e-9)


def test_a_ball_on_a_turning_beam_runs_off():
    ball = run(made("ball_and_beam", q=0.1, der_angle=2.0), 1.0)

    assert ball["q"] == pytest.approx(0.1 * math.cosh(2.0 / math.sqrt(1.4)), rel=1e-7)


def test_a_body_warms_exponentially():
    body = made("thermal_body", power=50.0, ambient=290.0, temperature=290.0, conductance=2.0)
    run(body, 300.0, h=1.0)

    assert body["temperature"] == pytest.approx(
        290.0 + 25.0 * (1.0 - math.exp(-2.0 / 500.0 * 300.0)), rel=1e-9
    )

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.linalg import expm

from fmu_sources.docking_contact.docking_contact import MODEL
from fmu_sources.framework.arithmetic import PYTHON
from fmu_sources.framework.instance import Instance, ModelError
from fmu_sources.framework.integrate import runge_kutta_4
from fmu_sources.framework.model import InputHold
from fmu_sources.framework.variables import Role

T = 1e-3
M_E, K_M, C_M, K_P, C_P = 80.0, 150e3, 158.0, 37.9e3, 65.0
A = np.array([[0, 1, 0], [-(K_M + K_P) / M_E, -(C_M + C_P) / M_E, -K_P / M_E], [0, 0, 0]])
B = np.array([[0, 0, 0], [K_P / M_E, C_P / M_E, -C_P / M_E], [0, 0, 1]])


def make(**values):
    instance = Instance(MODEL)
    for name, value in values.items():
        instance[name] = value
    instance.initialise()
    return instance


def linear_input(old, slope, h, x):
    """X after h for u = old + slope t, by matrix exponential."""
    big = np.zeros((9, 9))
    big[:3, :3], big[:3, 3:6], big[3:6, 6:] = A, B, np.eye(3)
    return (expm(big * h) @ np.r_[x, old, slope])[:3]


def states(contact):
    return [contact[name] for name in ("x_e", "der_x_e", "x")]


def test_ports_and_slots():
    assert [v.name for v in MODEL.group(Role.INPUT)] == ["s_act", "v_act", "v"]
    assert [v.name for v in MODEL.group(Role.OUTPUT)] == ["f_act"]
    assert [v.name for v in MODEL.group(Role.STATE) if v.output] == ["x"]
    assert [slot.name for slot in MODEL.slots] == ["rope_force", "guide_force", "manipulator_force"]


def test_it_starts_in_static_equilibrium():
    contact = make(s_act=-0.01, x=0.002)
    k_s = K_M * K_P / (K_M + K_P)

    assert contact["x_e"] == pytest.approx(-0.012 * K_P / (K_M + K_P), rel=1e-14)
    assert contact["f_act"] == pytest.approx(0.012 * k_s, rel=1e-14)
    for k in range(20):
        contact.step(k * T, T)
    assert contact["f_act"] == pytest.approx(0.012 * k_s, rel=1e-12)


def test_derivatives_and_output_by_hand():
    x = MODEL.states.record([0.01, 0.2, 0.003])
    u = MODEL.inputs.record([0.02, 0.5, 0.1])
    p = MODEL.parameters.record([2.0, 1000.0, 10.0, 400.0, 5.0, 100.0, 1.0, 1])
    der = MODEL.derivatives(0.25, x, u, p, PYTHON)
    f_r = 500.0 * (0.02 - 0.013) + 5.0 * (0.5 - 0.3)

    assert der == pytest.approx({"x_e": 0.2, "der_x_e": (f_r - 10.0 - 2.0) / 2.0, "x": 0.1})
    assert MODEL.outputs(0.25, x, u, p, PYTHON) == pytest.approx({"f_act": -12.0})


def test_the_slots_replace_the_forces():
    x = MODEL.states.record([0.01, 0.2, 0.0])
    u = MODEL.inputs.record([0.02, 0.5, 0.0])
    p = MODEL.parameters.record([2.0, 1000.0, 10.0, 400.0, 5.0, 0.0, 1.0, 1])
    seen = {}

    def slot(name, value, **signals):
        seen[name] = signals
        return {"rope_force": 7.0, "guide_force": 1.0, "manipulator_force": 2.0}[name]

    der = MODEL.derivatives(0.0, x, u, p, PYTHON, slot=slot)

    assert der["der_x_e"] == pytest.approx((7.0 - 1.0 - 2.0) / 2.0)
    assert {s.name: [*s.signals] for s in MODEL.slots} == {name: [*s] for name, s in seen.items()}
    assert seen["rope_force"] == pytest.approx({"r": 0.01, "der_r": 0.3})
    assert seen["guide_force"]["load"] == 7.0


def test_a_linear_input_gives_the_exact_response():
    contact = make(s_act=-0.01)
    x = np.array(states(contact))
    old = np.array([-0.01, 0.0, 0.0])
    for k, new in enumerate(([-0.009, 0.5, 0.1], [-0.0085, 0.9, 0.3], [-0.007, 1.4, 0.2])):
        for name, value in zip(("s_act", "v_act", "v"), new, strict=True):
            contact[name] = value
        contact.step(k * T, T)
        x = linear_input(old, (np.array(new) - old) / T, T, x)
        old = np.array(new)

        assert states(contact) == pytest.approx(x, rel=1e-8)
        assert contact["f_act"] == pytest.approx(-K_M * x[0] - C_M * x[1], rel=1e-8)


@pytest.mark.parametrize(("hold", "value"), [(InputHold.hold_new, 0.01), (InputHold.hold_old, 0.0)])
def test_a_held_input_gives_the_exact_response(hold, value):
    contact = make(input_hold=hold)
    contact["s_act"] = 0.01
    contact.step(0.0, T)
    exact = linear_input([value, 0, 0], [0, 0, 0], T, [0, 0, 0])

    assert states(contact) == pytest.approx(exact, rel=1e-6, abs=1e-15)


def test_the_declared_holds_are_half_a_step_apart():
    held = {d.input: d.steps for d in MODEL.delays}

    assert set(held) == {"s_act", "v_act", "v"}
    assert held["s_act"] == {"interpolate": 0.0, "hold_new": -0.5, "hold_old": 0.5}


def test_the_stiffness_varies_with_time():
    contact = make(k_p_amplitude=8e3, k_p_frequency=1.0, s_act=0.01)
    for k in range(250):
        contact.step(k * T, T)

    def f(t, x):
        k_p = K_P + 8e3 * math.sin(2 * math.pi * t)
        return [x[1], (k_p * (0.01 - x[0]) - K_M * x[0] - (C_M + C_P) * x[1]) / M_E]

    start = [0.01 * K_P / (K_M + K_P), 0.0]
    x = solve_ivp(f, (0.0, 0.25), start, "DOP853", rtol=1e-11, atol=1e-14).y[:, -1]

    assert states(contact)[:2] == pytest.approx(x, rel=1e-6)


def test_the_travel_integrates_the_drag_velocity():
    contact = make(v=0.1, x=0.5)
    for k in range(100):
        contact.step(k * T, T)

    assert contact["x"] == pytest.approx(0.51, rel=1e-12)


def test_runge_kutta_converges_with_order_four():
    u = MODEL.inputs.record([0.01, 0.0, 0.0])
    p = MODEL.parameters.record([M_E, K_M, C_M, K_P, C_P, 0.0, 1.0, 1])
    true = linear_input([0.01, 0, 0], [0, 0, 0], 0.05, [0, 0, 0])

    def error(n):
        h = 0.05 / n

        def f(place, x):
            return [h * d for d in MODEL.derivatives(0.0, MODEL.states.record(x), u, p, PYTHON).values()]

        return abs(runge_kutta_4(f, n, [0.0, 0.0, 0.0])[0] - true[0])

    assert math.log2(error(32) / error(64)) == pytest.approx(4.0, abs=0.3)


@pytest.mark.parametrize(
    ("name", "value", "message"),
    [
        ("m_e", 0.0, "m_e: value not allowed, got 0.0 kg, expected above 0.0"),
        ("k_p", -1.0, "k_p: value not allowed, got -1.0 N/m, expected above 0.0"),
        ("c_m", -1.0, "c_m: value not allowed, got -1.0 N s/m, expected at least 0.0"),
        (
            "input_hold",
            0,
            "input_hold: value not allowed, got 0, expected one of 1 (interpolate), 2 (hold_new), "
            "3 (hold_old)",
        ),
    ],
)
def test_a_bad_value_is_refused(name, value, message):
    with pytest.raises(ModelError) as error:
        make(**{name: value})

    assert str(error.value) == message

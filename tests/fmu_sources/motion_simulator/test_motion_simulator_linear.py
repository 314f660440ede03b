from __future__ import annotations

import math
import time

import numpy as np
import pytest
from scipy.linalg import expm

from fmu_sources.framework.arithmetic import PYTHON
from fmu_sources.framework.instance import Instance, ModelError
from fmu_sources.framework.integrate import n_substeps, runge_kutta_4
from fmu_sources.framework.variables import Role
from fmu_sources.motion_simulator.motion_simulator_linear import LINE_LENGTH, MODEL

T = 1e-3
K_P, W_V, Z = 30.0, 2 * math.pi * 20, 0.8
A = np.array([[0, 1, 0], [0, 0, 1], [-K_P * W_V**2, -(W_V**2), -2 * Z * W_V]])
B = np.array([0, 0, K_P * W_V**2])


def make(**values):
    instance = Instance(MODEL)
    for name, value in values.items():
        instance[name] = value
    instance.initialise()
    return instance


def exact(commands, s_start=0.0):
    """States after each period under held commands, by matrix exponential."""
    big = np.zeros((4, 4))
    big[:3, :3], big[:3, 3] = A, B
    E = expm(big * T)
    x, rows = np.array([s_start, 0.0, 0.0]), []
    for u in commands:
        x = E[:3] @ [*x, u]
        rows.append(x)
    return np.array(rows)


def stepped(simulator, commands):
    rows = []
    for k, u in enumerate(commands):
        simulator["s_cmd"] = u
        simulator.step(k * T, T)
        rows.append([simulator[name] for name in ("s_act", "v_act", "a_act")])
    return np.array(rows)


def test_ports_and_start_values():
    simulator = make(s_act=-0.01)

    assert [v.name for v in MODEL.group(Role.INPUT)] == ["s_cmd"]
    assert [v.name for v in MODEL.group(Role.STATE) if v.output] == ["s_act", "v_act"]
    assert (simulator["s_act"], simulator["v_act"], simulator["command[100]"]) == (-0.01, 0.0, -0.01)


def test_derivatives_by_hand():
    x = MODEL.states.record([0.1, 0.2, 0.3, 0.5, *[0.0] * LINE_LENGTH])
    p = MODEL.parameters.record([2.0, 10.0, 0.5, 0.0, T])
    der = MODEL.derivatives(0.0, x, None, p, PYTHON)

    assert der == pytest.approx({"s_act": 0.2, "v_act": 0.3, "a_act": 200 * 0.4 - 100 * 0.2 - 10 * 0.3})


def test_it_rests_where_it_starts():
    simulator = make(s_act=0.02)
    rows = stepped(simulator, [0.02] * 50)

    assert rows[:, 0] == pytest.approx(0.02, rel=1e-12)


@pytest.mark.parametrize("periods", [0, 1, 2, 57, LINE_LENGTH])
def test_a_command_acts_after_the_dead_time(periods):
    commands = 0.01 * np.sin(0.05 * np.arange(200))
    rows = stepped(make(dead_time=periods * T), commands)
    delayed = np.r_[np.zeros(periods), commands][: len(commands)]

    assert rows[:, 0] == pytest.approx(exact(delayed)[:, 0], abs=1e-10)
    assert rows[:, 1] == pytest.approx(exact(delayed)[:, 1], abs=1e-8)


@pytest.mark.parametrize(("dead_time", "periods"), [(0.0024, 2), (0.0026, 3), (0.0004, 0)])
def test_the_dead_time_is_rounded_to_the_nearest_period(dead_time, periods):
    rows, same = (stepped(make(dead_time=d), [0.01] * 5) for d in (dead_time, periods * T))

    assert (rows == same).all()


def test_runge_kutta_converges_with_order_four():
    hidden = [1.0, *[0.0] * LINE_LENGTH]
    p = MODEL.parameters.record([K_P, W_V, Z, 0.0, T])
    true = expm(np.block([[A, B[:, None]], [np.zeros((1, 4))]]) * 0.04)[:3, 3]

    def error(n):
        h = 0.04 / n

        def f(place, x):
            record = MODEL.states.record(x + hidden)
            return [h * d for d in MODEL.derivatives(0.0, record, None, p, PYTHON).values()]

        return np.abs(runge_kutta_4(f, n, [0.0, 0.0, 0.0]) - true)[0]

    assert math.log2(error(16) / error(32)) == pytest.approx(4.0, abs=0.3)
    assert n_substeps(T, MODEL.substep) >= 5


@pytest.mark.parametrize(
    ("frequency", "lag", "magnitude"),
    [(0.435, 5.53, 0.999), (0.875, 11.13, 0.996), (0.975, 12.39, 0.995), (2.617, 33.20, 0.965)],
)
def test_lag_and_magnitude_of_the_reduced_model(frequency, lag, magnitude):
    rows = stepped(make(), np.sin(2 * math.pi * frequency * T * np.arange(4000)))
    t = T * np.arange(1, 4001)
    late = t > 1.0
    waves = np.c_[np.sin(2 * math.pi * frequency * t), np.cos(2 * math.pi * frequency * t)]
    sin, cos = np.linalg.lstsq(waves[late], rows[late, 0], rcond=None)[0]
    hold = 180 * frequency * T

    assert math.hypot(sin, cos) == pytest.approx(magnitude, abs=1e-3)
    assert math.degrees(math.atan2(-cos, sin)) - hold == pytest.approx(lag, abs=0.03)


def test_a_full_delay_line_is_cheap():
    n_states = len(MODEL.states)
    x, u = MODEL.states.record([0.0] * n_states), MODEL.inputs.record([0.0])
    p = MODEL.parameters.record([K_P, W_V, Z, LINE_LENGTH * T, T])

    def once():
        start = time.perf_counter()
        MODEL.states.merged(MODEL.update(0.0, x, u, p, PYTHON), [0.0] * n_states)
        return time.perf_counter() - start

    assert min(once() for _ in range(200)) < 30e-6


@pytest.mark.parametrize(
    ("name", "value", "message"),
    [
        ("K_p", -1.0, "K_p: value not allowed, got -1.0 1/s, expected above 0.0"),
        ("dead_time", 0.2, "dead_time: value not allowed, got 0.2 s, expected at most 0.1"),
        ("dead_time", -0.001, "dead_time: value not allowed, got -0.001 s, expected at least 0.0"),
        ("sample_time", 1e-4, "sample_time: value not allowed, got 0.0001 s, expected at least 0.001"),
        ("s_cmd", math.inf, "s_cmd: value not allowed, got inf m, expected a finite number"),
    ],
)
def test_a_bad_value_is_refused(name, value, message):
    with pytest.raises(ModelError) as error:
        make(**{name: value})

    assert str(error.value) == message

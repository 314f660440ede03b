from __future__ import annotations

import math

import pytest

from fmu_sources.framework.instance import Instance, ModelError
from fmu_sources.framework.variables import Role
from fmu_sources.spacecraft.spacecraft import MODEL, Integrator

T = 1e-3


def make(**values):
    instance = Instance(MODEL)
    for name, value in values.items():
        instance[name] = value
    instance.initialise()
    return instance


def names(role):
    return [v.name for v in MODEL.group(role)]


def test_ports_and_start_values():
    spacecraft = make()

    assert names(Role.INPUT) == ["f"]
    assert [v.name for v in MODEL.group(Role.STATE) if v.output] == ["s_des", "v_des"]
    assert (spacecraft["m_s"], spacecraft["s_des"], spacecraft["v_des"]) == (820.0, 0.0, 0.0)


@pytest.mark.parametrize(
    ("integrator", "s_des"),
    [
        (Integrator.semi_implicit, 1.0 + 1e-3 * 2.005),
        (Integrator.zero_order_hold, 1.0 + 1e-3 * 2.0025),
        (Integrator.explicit_euler, 1.0 + 1e-3 * 2.0),
    ],
)
def test_one_step_from_motion_by_hand(integrator, s_des):
    spacecraft = make(m_s=200.0, s_des=1.0, v_des=2.0, f=1000.0, integrator=integrator)
    spacecraft.step(0.0, T)

    assert spacecraft["v_des"] == pytest.approx(2.005, rel=1e-15)
    assert spacecraft["s_des"] == pytest.approx(s_des, rel=1e-15)


@pytest.mark.parametrize(
    ("integrator", "steps_early"),
    [(Integrator.semi_implicit, 0.5), (Integrator.zero_order_hold, 0.0), (Integrator.explicit_euler, -0.5)],
)
def test_under_constant_force_the_integrators_are_half_a_step_apart(integrator, steps_early):
    n, m_s, f = 500, 820.0, 30.0
    spacecraft = make(f=f, integrator=integrator)
    for k in range(n):
        spacecraft.step(k * T, T)
    t = n * T

    assert spacecraft["s_des"] == pytest.approx(f / m_s * (t * t / 2 + steps_early * T * t), rel=1e-12)


def test_leapfrog_under_constant_force_is_on_the_parabola():
    """Exact at every instant: s = f t^2/(2 m_s); v_des is that of half a period before."""
    m_s, f = 200.0, 30.0
    spacecraft = make(m_s=m_s, f=f, integrator=Integrator.leapfrog)
    for k in range(1, 201):
        spacecraft.step((k - 1) * T, T)
        assert spacecraft["s_des"] == pytest.approx(f / m_s * (k * T) ** 2 / 2.0, rel=1e-12)
        assert spacecraft["v_des"] == pytest.approx(f / m_s * (k - 0.5) * T, rel=1e-12)


def test_leapfrog_on_a_spring_starts_at_the_turning_point():
    """With s = cos(k theta), cos(theta) = 1 - (w T)^2/2; semi_implicit adds -tan(theta/2) sin(k theta)."""
    m_s, k_spring = 1000.0, 267_000.0
    theta = math.acos(1.0 - k_spring / m_s * T * T / 2.0)
    starts = {Integrator.leapfrog: 0.0, Integrator.semi_implicit: math.tan(theta / 2.0)}
    for integrator, amplitude in starts.items():
        spacecraft = make(m_s=m_s, s_des=1.0, f=-k_spring, integrator=integrator)
        for k in range(1, 1001):
            spacecraft.step((k - 1) * T, T)
            expected = math.cos(k * theta) - amplitude * math.sin(k * theta)
            assert spacecraft["s_des"] == pytest.approx(expected, abs=1e-9)
            spacecraft["f"] = -k_spring * spacecraft["s_des"]


def test_leapfrog_halves_the_first_impulse_again_after_a_new_start():
    spacecraft = make(m_s=200.0, f=1000.0, integrator=Integrator.leapfrog)
    spacecraft.step(0.0, T)
    first = spacecraft["v_des"]
    spacecraft.step(T, T)
    spacecraft.reset()
    spacecraft["m_s"], spacecraft["f"], spacecraft["integrator"] = 200.0, 1000.0, Integrator.leapfrog
    spacecraft.initialise()
    spacecraft.step(0.0, T)

    assert spacecraft["v_des"] == first == pytest.approx(0.0025, rel=1e-15)


def test_many_periods_in_one_step_equal_single_steps():
    long, short = make(s_des=-0.01, f=5.0), make(s_des=-0.01, f=5.0)
    long.step(0.0, 5 * T)
    for k in range(5):
        short.step(k * T, T)

    assert long.values == short.values


def test_the_declared_delay_names_every_integrator():
    (delay,) = MODEL.delays

    assert delay.by == "integrator"
    assert set(delay.steps) == {item.name for item in Integrator}


@pytest.mark.parametrize(
    ("name", "value", "message"),
    [
        ("m_s", 0.0, "m_s: value not allowed, got 0.0 kg, expected above 0.0"),
        ("sample_time", -1e-3, "sample_time: value not allowed, got -0.001 s, expected above 0.0"),
        ("f", float("nan"), "f: value not allowed, got nan N, expected a finite number"),
        (
            "integrator",
            5,
            "integrator: value not allowed, got 5, expected one of 1 (semi_implicit), 2 (zero_order_hold), "
            "3 (explicit_euler), 4 (leapfrog)",
        ),
    ],
)
def test_a_bad_value_is_refused(name, value, message):
    with pytest.raises(ModelError) as error:
        make(**{name: value})

    assert str(error.value) == message

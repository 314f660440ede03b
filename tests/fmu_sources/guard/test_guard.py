"""The guard: what is a gain of energy and what is none, the limits, and how it holds."""

from __future__ import annotations

import math

import numpy as np
import pytest

from fmu_sources.composed.registry import load
from fmu_sources.framework.instance import Instance

T = 1e-3
W = 6.0
SIGNALS = ("s_des", "v_des", "s_act", "f_mea", "x", "v", "f_comp", "s_cmd")


def guard(**values: float) -> Instance:
    instance = Instance(load("guard"))
    for name, value in values.items():
        instance[name] = value
    instance.initialise()
    return instance


def answers(
    instance: Instance, n: int, *, stops: bool = False, **columns: np.ndarray | float
) -> dict[str, np.ndarray]:
    """Step with columns of inputs, each of n values or one; `stops`: only up to an alarm."""
    rows = {name: np.broadcast_to(np.asarray(column, dtype=float), (n,)) for name, column in columns.items()}
    found: dict[str, list[float]] = {
        name: [] for name in ("f_safe", "s_safe", "alarm", "reason", "energy_ratio")
    }
    for k in range(n):
        for name, column in rows.items():
            instance[name] = float(column[k])
        instance.step(k * T, T)
        for name, values in found.items():
            values.append(instance[name])
        if instance["alarm"] and stops:
            break
    return {name: np.array(values) for name, values in found.items()}


def swing(n: int, growth: float = 0.0, amplitude: float = 0.01, drift: float = 0.0) -> dict[str, np.ndarray]:
    """A swing from its turning point with its contact force, m_s = 820 kg; growth in 1/s, drift in m/s."""
    t = T * np.arange(n)
    s = amplitude * np.exp(growth * t) * np.cos(W * t)
    v = -amplitude * W * np.exp(growth * t) * np.sin(W * t)
    return {"s_des": s + drift * t, "v_des": v + drift, "s_act": s, "f_mea": -820.0 * W * W * s}


def first_alarm(found: dict[str, np.ndarray]) -> int | None:
    rows = np.flatnonzero(found["alarm"])
    return int(rows[0]) if len(rows) else None


@pytest.mark.parametrize("growth", [0.0, -0.05, -2.0])
def test_a_swing_that_gains_nothing_passes_bit_for_bit(growth):
    n = 3000
    rng = np.random.default_rng(3)
    f, s = rng.normal(size=n), rng.normal(size=n)

    found = answers(guard(), n, f_comp=f, s_cmd=s, **swing(n, growth))

    assert first_alarm(found) is None
    assert (found["f_safe"] == f).all()
    assert (found["s_safe"] == s).all()


def test_noise_of_the_velocity_at_a_turning_point_is_no_half_cycle():
    n = 4000
    rows = swing(n)
    rows["v_des"] = rows["v_des"] + 5e-4 * np.random.default_rng(5).normal(size=n)

    assert first_alarm(answers(guard(), n, **rows)) is None


def test_a_drift_below_a_swing_is_no_gain():
    """Peaks of 61 and 59 mm/s: the smaller one as budget would be exceeded by the larger."""
    n = 4000

    assert first_alarm(answers(guard(), n, **swing(n, drift=0.001))) is None


@pytest.mark.parametrize("per_cycle", [1.02, 1.1, 1.5, 3.0])
def test_a_motion_that_grows_is_caught_before_it_is_1_5_times_as_large(per_cycle):
    growth = math.log(per_cycle) * W / (2.0 * math.pi)
    n = int(math.log(2.0) / growth / T)

    k = first_alarm(answers(guard(), n, stops=True, **swing(n, growth)))

    assert k is not None
    assert math.exp(growth * k * T) < 1.5


@pytest.mark.parametrize(("slow_limit", "least", "most"), [(1.0, 1.04, 1.07), (1.8, 1.33, 1.37)])
def test_a_growth_within_the_tolerance_may_go_on_to_the_slow_limit(slow_limit, least, most):
    """1 % a cycle: the energy passes 1.1 at 1.049 times the amplitude, 1.8 at 1.342 times."""
    growth = math.log(1.01) * W / (2.0 * math.pi)
    n = 33_000

    instance = guard(tolerance=0.1, slow_limit=slow_limit)
    k = first_alarm(answers(instance, n, stops=True, **swing(n, growth)))

    assert k is not None
    assert least < math.exp(growth * k * T) < most


@pytest.mark.parametrize(("tolerance", "cycles"), [(0.05, 0.25), (0.1, 0.75)])
def test_the_alarm_comes_at_the_first_peak_of_speed_that_has_gained_the_tolerance(tolerance, cycles):
    """Growth by 1.15 a cycle: 1.15^(1/2) = 1.072 of the energy at a quarter, 1.15^(3/2) = 1.233 at 3/4."""
    growth = math.log(1.15) * W / (2.0 * math.pi)

    k = first_alarm(answers(guard(tolerance=tolerance), 1000, stops=True, **swing(1000, growth)))

    assert k is not None
    assert k * T * W / (2.0 * math.pi) == pytest.approx(cycles, abs=0.05)


def test_the_first_budget_is_the_energy_at_the_start():
    """Speed against the foot and force at the start: u^2 + |f (s - x)|/m, here 0.02^2 + 41*0.004/820."""
    budget = 0.02**2 + 41.0 * 0.004 / 820.0
    instance = guard()
    start = {"s_des": 0.006, "x": 0.002, "v_des": 0.03, "v": 0.01, "f_mea": -41.0}

    found = answers(instance, 1, **start)
    assert found["energy_ratio"][0] == pytest.approx(0.02**2 / budget, rel=1e-12)

    for factor, alarm in ((1.0499, 0.0), (1.0501, 1.0)):  # sqrt(1.1025), tolerance 0.1025
        instance = guard(tolerance=0.1025)
        answers(instance, 1, **start)
        found = answers(instance, 1, **{**start, "v_des": 0.01 + factor * math.sqrt(budget)})
        assert found["alarm"][0] == alarm
        assert found["reason"][0] == alarm


def test_a_declared_noise_may_have_made_the_first_force_too_small():
    """Three deviations of 2 N, on a force of 41 N over 6 mm that moves 820 kg."""
    budget = (41.0 + 3.0 * 2.0) * 0.006 / 820.0
    for energy, alarm in ((1.0499 * budget, 0.0), (1.0501 * budget, 1.0)):
        instance = guard(tolerance=0.05, force_noise=2.0)
        answers(instance, 1, s_des=0.006, f_mea=-41.0)
        assert answers(instance, 1, v_des=math.sqrt(energy))["alarm"][0] == alarm


@pytest.mark.parametrize(
    ("share", "least", "most"), [(0.0, 0.25, 0.35), (0.5, 0.72, 0.78), (1.0, 1.02, 1.105)]
)
def test_a_motion_that_has_shrunk_may_grow_to_a_share_of_the_energy_at_the_start(share, least, most):
    """A quarter after 4 s, then growth by 1.15 a cycle: alarm at sqrt(1.05 share) or half a cycle on."""
    t = T * np.arange(16_000)
    down = math.log(4.0) / 4.0
    up = math.log(1.15) * W / (2.0 * math.pi)
    envelope = 0.01 * np.exp(-down * np.minimum(t, 4.0) + up * np.maximum(t - 4.0, 0.0))
    s, v = envelope * np.cos(W * t), -envelope * W * np.sin(W * t)
    rows = {"s_des": s, "v_des": v, "s_act": s, "f_mea": -820.0 * W * W * s}

    k = first_alarm(answers(guard(start_share=share), len(t), stops=True, **rows))

    assert k is not None
    assert t[k] > 4.0
    assert least < envelope[k] / envelope[0] < most


def test_a_motion_from_rest_has_no_energy_at_the_start_to_grow_to():
    """From 2 mm/s, which is not watched below, by 1.15 a cycle: alarm long before 10 mm."""
    growth = math.log(1.15) * W / (2.0 * math.pi)

    k = first_alarm(answers(guard(), 20_000, stops=True, **swing(20_000, growth, amplitude=1e-4)))

    assert k is not None
    assert math.exp(growth * k * T) * 1e-4 < 3e-4


def test_a_declared_variation_of_the_stiffness_widens_the_budget():
    """Stiffness from 0.8 to 1.2 of its mean: (1 + 0.1) 1.2/0.8 = 1.65 of the energy."""
    for energy, alarm in ((1.649, 0.0), (1.651, 1.0)):
        instance = guard(tolerance=0.1, variation=0.2)
        answers(instance, 1, v_des=0.05)
        assert answers(instance, 1, v_des=0.05 * math.sqrt(energy))["alarm"][0] == alarm


def test_what_is_slower_than_the_least_speed_is_no_gain():
    instance = guard(least_speed=2e-3)
    answers(instance, 1, v_des=0.0)

    assert answers(instance, 1, v_des=2.0e-3)["alarm"][0] == 0.0
    assert answers(instance, 1, v_des=2.2e-3)["alarm"][0] == 1.0


@pytest.mark.parametrize(
    ("limit", "value", "signals", "reason"),
    [
        ("largest_displacement", 0.02, {"s_des": -0.0201, "s_act": -0.0201}, 2.0),
        ("largest_deviation", 0.005, {"s_des": 0.0, "s_act": 0.00501}, 3.0),
        ("largest_force", 400.0, {"f_mea": -400.1}, 4.0),
        ("largest_speed", 0.03, {"v_des": -0.0301}, 5.0),
    ],
)
def test_each_limit_has_its_reason_and_is_none_at_zero(limit, value, signals, reason):
    start = {"v_des": 0.05}
    for given, expected in ((value, reason), (0.0, 0.0)):
        instance = guard()
        answers(instance, 1, **start)
        instance[limit] = given
        assert answers(instance, 1, v_des=0.0)["reason"][0] == 0.0
        assert answers(instance, 1, **{"v_des": 0.0, **signals})["reason"][0] == expected


def test_an_alarm_stays_with_its_first_reason():
    instance = guard(largest_force=100.0)
    answers(instance, 1, v_des=0.01)
    answers(instance, 1, f_mea=120.0)

    found = answers(instance, 3, f_mea=0.0, v_des=5.0)
    assert list(found["alarm"]) == [1.0] * 3
    assert list(found["reason"]) == [4.0] * 3


def test_it_holds_without_force_and_its_command_comes_to_rest():
    """From s = 4 mm at u = 20 mm/s: a geometric series, T u/(1 - exp(-T/rest_time)) further in the end."""
    instance = guard(largest_force=100.0, rest_time=0.05)
    moving = {"v_des": 0.02, "f_comp": -30.0}
    answers(instance, 1, s_cmd=0.004, **moving)

    found = answers(instance, 2000, s_cmd=0.9, f_mea=120.0, **moving)

    way = T * 0.02 / -math.expm1(-T / 0.05)
    assert (found["f_safe"] == 0.0).all()
    assert found["s_safe"][0] == pytest.approx(0.004 + T * 0.02, rel=1e-12)
    assert found["s_safe"][-1] == pytest.approx(0.004 + way, rel=1e-12)
    assert np.abs(np.diff(found["s_safe"])).max() <= T * 0.02


def test_a_guard_that_is_off_passes_all_on():
    found = answers(guard(active=False), 2, v_des=[0.0, 5.0], f_comp=3.0, s_cmd=0.1)

    assert list(found["alarm"]) == [0.0, 0.0]
    assert found["energy_ratio"][1] > 100.0
    assert (found["f_safe"][1], found["s_safe"][1]) == (3.0, 0.1)


def test_terminals_name_variables_that_exist():
    model = load("guard")
    names = {v.name for v in model.all_variables}

    assert {v for t in model.terminals for v in t.members.values()} <= names
    assert set(SIGNALS) == set(model.inputs.names)

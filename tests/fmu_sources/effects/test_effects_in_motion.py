"""Motion with an effect is that of its law in an independent solver, and native code does the same."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from fmu_sources.composed.composition import with_effect
from fmu_sources.effects.catalogue import effect
from fmu_sources.framework.arithmetic import PYTHON
from fmu_sources.framework.instance import Instance
from tests.fmu_sources.export.native.native_library import GUID, Fmu3

H, N = 1e-3, 500
START = [0.02, 0.0]

ADDED_TO_THE_SPRING = {
    "magnet": (
        {"pull": 0.5, "gap": 0.06, "side": -1.0},
        lambda t, y, v: 0.5 * ((0.06 / (0.06 + y)) ** 2 - 1.0),
    ),
    "second_stage": (
        {"limit": 0.005, "stiffness": 300.0, "side": -1.0},
        lambda t, y, v: -300.0 * max(-y - 0.005, 0.0),
    ),
    "parametric_stiffness": (
        {"sine": 200.0, "cosine": 90.0, "frequency": 3.0},
        lambda t, y, v: y * (200.0 * math.sin(6.0 * math.pi * t) + 90.0 * math.cos(6.0 * math.pi * t)),
    ),
    "squeeze_film": (
        {"coefficient": 3.0, "gap": 0.06, "side": 1.0},
        lambda t, y, v: 3.0 * v / (1.0 - y / 0.06) ** 3,
    ),
    "structural_damping": (
        {"coefficient": 100.0, "smoothing": 0.02},
        lambda t, y, v: 100.0 * abs(y) * math.tanh(v / 0.02),
    ),
    "power_law": (
        {"amplitude": 5.0, "exponent": 1.5, "reference": 0.02},
        lambda t, y, v: math.copysign(5.0 * (abs(y) / 0.02) ** 1.5, y),
    ),
    "overflow": (
        {"amplitude": 5.0, "edge": 0.005, "reference": 0.02},
        lambda t, y, v: 5.0 * (max(y - 0.005, 0.0) / 0.02) ** 1.5,
    ),
}


def moved(model, names=("y", "der_y"), n=N):
    instance = Instance(model)
    instance.initialise()
    for k in range(n):
        instance.step(k * H, H)
    return [instance[name] for name in names]


def solved(law, start=START, at=(N * H,)):
    return solve_ivp(law, (0.0, N * H), start, t_eval=at, rtol=1e-11, atol=1e-14, max_step=1e-3).y[:, -1]


@pytest.mark.parametrize("name", ADDED_TO_THE_SPRING)
def test_motion_with_a_law_without_memory_is_that_of_an_independent_solver(oscillator, name):
    starts, added = ADDED_TO_THE_SPRING[name]

    exact = solved(lambda t, z: [z[1], -(800.0 * z[0] + 4.0 * z[1] + added(t, *z)) / 2.0])
    assert moved(with_effect(oscillator, "spring", effect(name), starts=starts)) == pytest.approx(
        exact, abs=2e-7
    )


def test_a_relaxing_spring_moves_as_the_standard_solid(oscillator):
    """With what the damper has yielded as the third state, from rest in the arm."""
    model = with_effect(
        oscillator, "spring", effect("relaxation"), starts={"stiffness": 500.0, "time_constant": 0.05}
    )

    def law(t, z):
        arm = 500.0 * (z[0] - z[2])
        return [z[1], -(800.0 * z[0] + 4.0 * z[1] + arm) / 2.0, (z[0] - z[2]) / 0.05]

    y, v, yielded = solved(law, [*START, 0.02])
    names = ("y", "der_y", "spring_relaxation_elongation")
    assert moved(model, names) == pytest.approx([y, v, y - yielded], abs=2e-7)


def test_a_mode_shakes_with_the_spring(oscillator):
    """With the position of the mode itself as the third state."""
    starts = {"stiffness": 300.0, "frequency": 5.0, "damping": 0.1}
    model = with_effect(oscillator, "spring", effect("torsion_mode"), starts=starts)
    w = 10.0 * math.pi

    def law(t, z):
        y, v, q, u = z
        force = 800.0 * y + 4.0 * v + 300.0 * (y - q)
        return [v, -force / 2.0, u, w * w * (y - q) - 0.2 * w * u]

    y, v, q, u = solved(law, [*START, 0.02, 0.0])
    names = ("y", "der_y", "spring_torsion_mode_lag", "spring_torsion_mode_speed")
    assert moved(model, names) == pytest.approx([y, v, y - q, u], abs=5e-7)


def test_contacts_age_and_are_renewed(oscillator):
    starts = {
        "level": 1.0,
        "direct": 0.5,
        "evolution": 0.7,
        "length": 5e-3,
        "reference": 0.01,
        "smoothing": 0.02,
    }
    model = with_effect(oscillator, "spring", effect("ageing_contacts"), starts=starts)

    def law(t, z):
        y, v, age = z
        size = 1.0 + 0.5 * math.log1p(abs(v) / 0.01) + 0.7 * math.log1p(age * 2.0)
        return [v, -(800.0 * y + 4.0 * v + size * math.tanh(v / 0.02)) / 2.0, 1.0 - abs(v) * age / 5e-3]

    names = ("y", "der_y", "spring_ageing_contacts_age")
    assert moved(model, names) == pytest.approx(solved(law, [*START, 0.0]), abs=2e-6)


def test_a_sensor_with_hysteresis_is_a_share_behind_a_play():
    """Up to 10, down to 4 and back up to 6, slowly: behind a play of +-1 that is 9, 5, 5."""
    found = effect("sensor_hysteresis")
    p, followed, h = found.parameter_record.record([0.4, 1.0]), 0.0, 1e-4
    shown = []
    for start, end in ((0.0, 10.0), (10.0, 4.0), (4.0, 6.0)):
        for value in np.linspace(start, end, 20_000):
            applied = found.law(0.0, value, None, found.state_record.record([followed]), p, PYTHON)
            followed += h * applied.changes["followed"]
        shown.append(applied.value)

    expected = [0.6 * value + 0.4 * behind for value, behind in ((10.0, 9.0), (4.0, 5.0), (6.0, 5.0))]
    assert shown == pytest.approx(expected, abs=1e-3)


def test_a_creeping_sensor_answers_a_step_by_its_prony_series():
    """Times 0.1, 0.2, 0.4, 0.8 s of shares 0.1, -0.05, 0.2, 0.02; at rest before."""
    law, shares, times = effect("creep").law, (0.1, -0.05, 0.2, 0.02), (0.1, 0.2, 0.4, 0.8)
    p = effect("creep").parameter_record.record([*shares, 0.1, 0.8])

    def rates(t, z):
        return list(law(t, 5.0, None, effect("creep").state_record.record(z), p, PYTHON).changes.values())

    at = (0.05, 0.3, 0.5)
    crept = solve_ivp(rates, (0.0, 0.5), np.zeros(4), t_eval=at, rtol=1e-11, atol=1e-13).y.T
    shown = [law(0.0, 5.0, None, effect("creep").state_record.record(z), p, PYTHON).value for z in crept]

    exact = [
        5.0 * (1.0 - sum(c * math.exp(-t / tau) for c, tau in zip(shares, times, strict=True))) for t in at
    ]
    assert shown == pytest.approx(exact, rel=1e-9)


def test_a_creeping_sensor_of_a_model_begins_at_rest_and_follows_the_force(oscillator):
    starts = {"share_2": 0.2, "share_4": 0.1, "shortest": 0.02, "longest": 0.16}
    model = with_effect(oscillator, "sensor", effect("creep"), starts=starts)

    def law(t, z):
        f = 800.0 * z[0] + 4.0 * z[1]
        return [z[1], -f / 2.0, (f - z[2]) / 0.04, (f - z[3]) / 0.16]

    y, v, quick, slow = solved(law, [*START, 16.0, 16.0])
    f = 800.0 * y + 4.0 * v
    assert moved(model, ("f",)) == pytest.approx([f + 0.2 * (quick - f) + 0.1 * (slow - f)], abs=1e-5)


STACKED = (
    ("spring", "magnet", {"pull": 0.5, "gap": 0.06}),
    ("spring", "second_stage", {"limit": 0.005, "stiffness": 300.0, "side": -1.0}),
    ("spring", "parametric_stiffness", {"sine": 200.0, "cosine": 90.0, "frequency": 3.0}),
    ("spring", "relaxation", {"stiffness": 500.0, "time_constant": 0.05}),
    ("spring", "squeeze_film", {"coefficient": 3.0, "gap": 0.06}),
    ("spring", "structural_damping", {"coefficient": 100.0}),
    ("spring", "torsion_mode", {"stiffness": 300.0, "frequency": 5.0}),
    ("spring", "ageing_contacts", {"level": 1.0, "direct": 0.5, "evolution": 0.7}),
    ("spring", "power_law", {"amplitude": 5.0, "reference": 0.02}),
    ("spring", "overflow", {"amplitude": 5.0, "edge": 0.005, "reference": 0.02}),
    ("sensor", "sensor_hysteresis", {"share": 0.4, "width": 1.0}),
    ("sensor", "creep", {"share_1": 0.1, "share_3": 0.2}),
    ("sensor", "warm_up", {"amplitude": 3.0, "time_constant": 0.2}),
    ("sensor", "dead_zone", {"width": 0.5}),
    ("sensor", "one_sided_saturation", {"limit": 12.0}),
    ("sensor", "missing_codes", {"distance": 0.7, "share": 0.3}),
)


def test_native_code_of_all_of_them_at_once_gives_the_bits_of_python(oscillator, tmp_path):
    native = pytest.importorskip("fmu_sources.export.native")
    model = oscillator
    for slot, name, starts in STACKED:
        model = with_effect(model, slot, effect(name), starts=starts)
    path = tmp_path / "stacked.so"
    path.write_bytes(native.compile_host(native.generate(model, GUID), "stacked"))
    python, compiled = Instance(model), Fmu3(path, model)
    python.initialise()
    assert compiled.initialise() == 0
    rows = []
    for k in range(200):
        python.step(k * H, H)
        assert compiled.step(k * H, H) == 0
        rows.append(
            [[get(name) for name in ("y", "der_y", "f")] for get in (python.__getitem__, compiled.get)]
        )
    compiled.free()

    assert [own for own, _ in rows] == [other for _, other in rows]
    assert np.ptp([own for own, _ in rows], axis=0).min() > 0.0

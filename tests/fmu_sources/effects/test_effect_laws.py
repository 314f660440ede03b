"""Values of each law at points calculated by hand."""

from __future__ import annotations

import math
from types import SimpleNamespace

import pytest

from fmu_sources.effects.catalogue import effect, listed
from fmu_sources.effects.framework.roles import Signals
from fmu_sources.framework.arithmetic import PYTHON

T1 = math.tanh(1.0)
POINTS = [
    # effect, parameters, signals, states, value -> expected
    ("coulomb", {"level": 5.0, "smoothing": 0.1}, {"velocity": 0.1}, {}, 10.0, 10.0 + 5.0 * T1),
    ("coulomb", {"level": 5.0, "smoothing": 1e-3}, {"velocity": -0.1}, {}, 10.0, 5.0),
    (
        "stribeck",
        {"level": 5.0, "breakaway": 2.0, "stribeck_velocity": 0.1, "smoothing": 0.1},
        {"velocity": 0.1},
        {},
        0.0,
        (5.0 + 2.0 / math.e) * T1,
    ),
    (
        "asymmetric_friction",
        {"forward": 3.0, "backward": 7.0, "damping_difference": 2.0, "smoothing": 1e-4},
        {"velocity": 1.0},
        {},
        1.0,
        1.0 + 3.0 + 2.0,
    ),
    (
        "asymmetric_friction",
        {"forward": 3.0, "backward": 7.0, "damping_difference": 2.0, "smoothing": 1e-4},
        {"velocity": -1.0},
        {},
        1.0,
        1.0 - 7.0,
    ),
    (
        "load_friction",
        {"coefficient": 0.1, "smoothing": 1e-4},
        {"velocity": 1.0, "load": -50.0},
        {},
        0.0,
        5.0,
    ),
    ("quadratic_damping", {"coefficient": 2.0}, {"velocity": -3.0}, {}, 1.0, -17.0),
    ("cubic_stiffness", {"coefficient": 2.0}, {"position": -3.0}, {}, 1.0, -53.0),
    ("quadratic_stiffness", {"coefficient": 2.0}, {"position": -3.0}, {}, 1.0, 19.0),
    ("slack", {"limit": 1e-3, "side": 1.0, "width": 1e-5}, {"position": 2e-3}, {}, 80.0, 0.0),
    ("slack", {"limit": 1e-3, "side": 1.0, "width": 1e-5}, {"position": 1e-3}, {}, 80.0, 40.0),
    ("slack", {"limit": 1e-3, "side": -1.0, "width": 1e-5}, {"position": 2e-3}, {}, 80.0, 80.0),
    ("clearance", {"gap": 1.0, "stiffness": 10.0}, {"position": 0.5}, {}, 5.0, 0.0),
    ("clearance", {"gap": 1.0, "stiffness": 10.0}, {"position": -3.0}, {}, -30.0, -20.0),
    ("end_stop", {"limit": 1.0, "stiffness": 10.0}, {"position": 0.9}, {}, 5.0, 5.0),
    ("end_stop", {"limit": 1.0, "stiffness": 10.0}, {"position": -3.0}, {}, 5.0, -15.0),
    (
        "presliding",
        {"stiffness": 100.0, "forward": 10.0, "backward": 10.0},
        {"position": 9.0, "velocity": 1.0},
        {"elongation": 0.05},
        1.0,
        6.0,
    ),
    ("dahl", {"level": 4.0, "length": 0.1}, {"position": 0.0, "velocity": 1.0}, {"share": -0.5}, 1.0, -1.0),
    (
        "bouc_wen",
        {"level": 4.0, "length": 0.1, "shape": 0.5},
        {"position": 0.0, "velocity": 1.0},
        {"share": 0.5},
        1.0,
        3.0,
    ),
    ("offset", {"offset": -3.0}, {}, {}, 1.0, -2.0),
    ("drift", {"rate": 0.5}, {}, {}, 1.0, 2.0),
    ("gain_error", {"error": 0.1}, {}, {}, 10.0, 11.0),
    ("extra_lag", {"time_constant": 0.02}, {}, {"lagged": 3.0}, 10.0, 3.0),
    (
        "mount_resonance",
        {"share": 0.5, "frequency": 1.0, "damping": 0.1},
        {},
        {"carried": 4.0, "rate": 0.0},
        2.0,
        3.0,
    ),
    ("end_effector_inertia", {"ratio": 1e-6}, {}, {"filtered": 1.0, "rate": 0.0}, 2.0, 2.0 + 1.0),
    ("ripple", {"sine": 2.0, "cosine": 3.0, "period": 0.4}, {"position": 0.1}, {}, 1.0, 3.0),
    ("rate_saturation", {"limit": 100.0}, {}, {"followed": 1.0}, 5.0, 1.1),
    ("rate_saturation", {"limit": 100.0}, {}, {"followed": 1.0}, 1.05, 1.05),
    ("force_saturation", {"limit": 2.0}, {}, {}, -5.0, -2.0),
    ("quantisation", {"step": 0.5}, {}, {}, 1.3, 1.5),
    ("quantisation", {"step": 0.5}, {}, {}, -1.3, -1.5),
    # the gap of 3 is 2 where the position is 1: (3 / 2)^2 - 1 = 5 / 4
    ("magnet", {"pull": 4.0, "gap": 3.0, "side": 1.0}, {"position": 1.0}, {}, 7.0, 2.0),
    ("magnet", {"pull": 4.0, "gap": 3.0, "side": -1.0}, {"position": -1.0}, {}, 7.0, 12.0),
    ("magnet", {"pull": 1.0, "gap": 3.0, "side": 1.0}, {"position": 9.0}, {}, 0.0, -399.0),
    ("second_stage", {"limit": 1.0, "stiffness": 10.0, "side": 1.0}, {"position": 3.0}, {}, 5.0, 25.0),
    ("second_stage", {"limit": 1.0, "stiffness": 10.0, "side": 1.0}, {"position": -3.0}, {}, 5.0, 5.0),
    ("second_stage", {"limit": 1.0, "stiffness": 10.0, "side": -1.0}, {"position": -3.0}, {}, 5.0, -15.0),
    (  # at t = 2: a sixteenth of a turn after 2 1/8 turns is 1/8 + 2
        "parametric_stiffness",
        {"sine": 2.0, "cosine": 4.0, "frequency": 1.0625},
        {"position": 3.0},
        {},
        1.0,
        1.0 + 3.0 * math.sqrt(0.5) * 6.0,
    ),
    (
        "relaxation",
        {"stiffness": 10.0, "time_constant": 0.5},
        {"position": 3.0, "velocity": 1.0},
        {"elongation": 2.0},
        5.0,
        25.0,
    ),
    ("dead_zone", {"width": 2.0}, {}, {}, 5.0, 3.0),
    ("dead_zone", {"width": 2.0}, {}, {}, -1.5, 0.0),
    ("one_sided_saturation", {"limit": 2.0, "side": 1.0}, {}, {}, 5.0, 2.0),
    ("one_sided_saturation", {"limit": 2.0, "side": 1.0}, {}, {}, -5.0, -5.0),
    ("one_sided_saturation", {"limit": 2.0, "side": -1.0}, {}, {}, -5.0, -2.0),
    ("one_sided_saturation", {"limit": -2.0, "side": 1.0}, {}, {}, 5.0, -2.0),
    ("warm_up", {"amplitude": 3.0, "time_constant": 2.0}, {}, {}, 1.0, 4.0 - 3.0 / math.e),
    (
        "creep",
        {"share_1": 0.1, "share_2": 0.2, "share_3": 0.3, "share_4": 0.4, "shortest": 1.0, "longest": 8.0},
        {},
        {"crept_1": 1.0, "crept_2": 2.0, "crept_3": 3.0, "crept_4": 4.0},
        10.0,
        10.0 - 0.9 - 1.6 - 2.1 - 2.4,
    ),
    ("missing_codes", {"distance": 2.0, "share": 0.5}, {}, {}, 4.4, 4.0),
    ("missing_codes", {"distance": 2.0, "share": 0.5}, {}, {}, -4.4, -4.0),
    ("missing_codes", {"distance": 2.0, "share": 0.5}, {}, {}, 4.6, 4.6),
    ("missing_codes", {"distance": 2.0, "share": 1.0}, {}, {}, 4.9, 4.0),
    ("overflow", {"amplitude": 2.0, "edge": 1.0, "reference": 0.5}, {"position": 3.0}, {}, 1.0, 17.0),
    ("overflow", {"amplitude": 2.0, "edge": 1.0, "reference": 0.5}, {"position": -3.0}, {}, 1.0, 1.0),
    ("power_law", {"amplitude": 3.0, "exponent": 0.5, "reference": 2.0}, {"position": 8.0}, {}, 1.0, 7.0),
    ("power_law", {"amplitude": 3.0, "exponent": 1.5, "reference": 2.0}, {"position": -8.0}, {}, 1.0, -23.0),
    (
        "ageing_contacts",
        {"level": 3.0, "direct": 2.0, "evolution": 4.0, "length": 0.5, "reference": 0.1, "smoothing": 1e-4},
        {"position": 0.0, "velocity": -0.1},
        {"age": 15.0},
        1.0,
        1.0 - 3.0 - 2.0 * math.log(2.0) - 4.0 * math.log(4.0),
    ),
    ("sensor_hysteresis", {"share": 0.5, "width": 1.0}, {}, {"followed": 3.0}, 5.0, 4.0),
    (
        "squeeze_film",
        {"coefficient": 2.0, "gap": 2.0, "side": 1.0},
        {"position": 1.0, "velocity": 3.0},
        {},
        1.0,
        49.0,
    ),
    (
        "squeeze_film",
        {"coefficient": 2.0, "gap": 2.0, "side": -1.0},
        {"position": -1.0, "velocity": 3.0},
        {},
        1.0,
        49.0,
    ),
    (
        "structural_damping",
        {"coefficient": 2.0, "smoothing": 1e-4},
        {"position": -3.0, "velocity": 1.0},
        {},
        1.0,
        7.0,
    ),
    (
        "torsion_mode",
        {"stiffness": 4.0, "frequency": 1.0, "damping": 0.1},
        {"position": 0.0, "velocity": 1.0},
        {"lag": 2.0, "speed": 0.5},
        1.0,
        9.0,
    ),
]
RATES = [
    ("presliding", {"stiffness": 100.0, "forward": 10.0, "backward": 10.0}, 1.0, {"elongation": 0.05}, 1.0),
    ("presliding", {"stiffness": 100.0, "forward": 10.0, "backward": 10.0}, 1.0, {"elongation": 0.1001}, 0.0),
    (
        "presliding",
        {"stiffness": 100.0, "forward": 10.0, "backward": 10.0},
        -1.0,
        {"elongation": 0.1001},
        -1.0,
    ),
    ("dahl", {"level": 4.0, "length": 0.1}, -2.0, {"share": 0.5}, (-2.0 - 1.0) / 0.1),
    (
        "bouc_wen",
        {"level": 4.0, "length": 0.1, "shape": 0.75},
        1.0,
        {"share": -0.5},
        (1 + 0.75 / 4 - 0.25 / 4) / 0.1,
    ),
    ("extra_lag", {"time_constant": 0.02}, 0.0, {"lagged": 3.0}, (10.0 - 3.0) / 0.02),
    ("rate_saturation", {"limit": 100.0}, 0.0, {"followed": 1.0}, 100.0),
    ("relaxation", {"stiffness": 10.0, "time_constant": 0.5}, 3.0, {"elongation": 1.0}, 1.0),
    ("sensor_hysteresis", {"share": 0.5, "width": 1.0}, 0.0, {"followed": 8.0}, 1.0 / 0.2e-3),
    ("sensor_hysteresis", {"share": 0.5, "width": 1.0}, 0.0, {"followed": 10.5}, 0.0),
    (
        "torsion_mode",
        {"stiffness": 4.0, "frequency": 1.0, "damping": 0.1},
        3.0,
        {"lag": 2.0, "speed": 0.5},
        2.5,
    ),
    (
        "ageing_contacts",
        {"level": 3.0, "direct": 2.0, "evolution": 4.0, "length": 0.5, "reference": 0.1, "smoothing": 1e-4},
        -0.1,
        {"age": 15.0},
        -2.0,
    ),
]


@pytest.mark.parametrize(("name", "p", "s", "x", "value", "expected"), POINTS)
def test_law_gives_the_value_calculated_by_hand(name, p, s, x, value, expected):
    applied = effect(name).law(2.0, value, Signals(**s), SimpleNamespace(**x), SimpleNamespace(**p), PYTHON)

    assert expected == pytest.approx(applied.value, abs=1e-12)


@pytest.mark.parametrize(("name", "p", "velocity", "x", "expected"), RATES)
def test_state_changes_at_the_rate_calculated_by_hand(name, p, velocity, x, expected):
    s = Signals(position=0.0, velocity=velocity)
    changes = effect(name).law(0.0, 10.0, s, SimpleNamespace(**x), SimpleNamespace(**p), PYTHON).changes

    assert expected == pytest.approx(next(iter(changes.values())), abs=1e-12)


@pytest.mark.parametrize("name", listed())
def test_every_listed_effect_has_a_point_calculated_by_hand_or_a_test_of_its_own(name):
    assert name in {point[0] for point in POINTS} | {"extra_delay"}


@pytest.mark.parametrize("dead_time", [0.3e-3, 1e-3, 5e-3])
def test_dead_time_delays_a_ramp_by_itself(dead_time):
    law, p = effect("extra_delay").law, SimpleNamespace(dead_time=dead_time)
    t_c = max(dead_time, 1e-3)
    x = SimpleNamespace(filtered=7.0 - 2.0 * t_c / 2.0, rate=2.0)  # the ramp 2 t at rest behind the filter

    applied = law(0.0, 7.0, Signals(), x, p, PYTHON)

    assert 7.0 - 2.0 * dead_time == pytest.approx(applied.value, abs=1e-12)
    assert applied.changes == pytest.approx({"filtered": 2.0, "rate": 0.0}, abs=1e-6)


@pytest.mark.parametrize("name", listed())
def test_absent_parameters_leave_the_value(name, values_of):
    found = effect(name)
    s = Signals(position=0.007, velocity=-0.3, load=50.0)
    x = SimpleNamespace(**{v.name: 0.3 for v in found.states})

    applied = found.law(3.0, 12.5, s, x, values_of(found, **found.absent), PYTHON)

    assert applied.value == 12.5


@pytest.mark.parametrize("name", listed())
def test_scale_names_parameters_and_keeps_their_rules(name, values_of):
    found = effect(name)
    values = vars(values_of(found))

    assert {v.name for v in found.parameters} == set(values)
    assert [v.broken_rule(values[v.name]) for v in found.parameters] == [None] * len(values)
    assert set(found.absent) <= set(values)

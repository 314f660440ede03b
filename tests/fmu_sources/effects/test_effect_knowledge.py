"""What an effect declares of itself is true of its law."""

from __future__ import annotations

import math
from types import SimpleNamespace

import numpy as np
import pytest

from fmu_sources.composed.composition import AND, SEPARATOR
from fmu_sources.effects.catalogue import constant, effect, listed
from fmu_sources.effects.framework.effect import FirstGuess, Place, Rms
from fmu_sources.effects.framework.experiment import Experiment
from fmu_sources.effects.framework.roles import Signals
from fmu_sources.framework.arithmetic import PYTHON

N, PERIOD, AMPLITUDE = 4000, 1.0, 0.01
RMS = Rms(
    value=100.0,
    position=AMPLITUDE / math.sqrt(2.0),
    velocity=2.0 * math.pi * AMPLITUDE / math.sqrt(2.0),
    load=100.0,
    duration=10.0,
)


def force(found, values, n_periods=2, n=N):
    """What a law adds over the second period of a sine, integrated in small steps."""
    p = SimpleNamespace(**({v.name: v.start for v in found.parameters} | dict(values)))
    size = 0.0 if Place.MECHANICAL in found.places else math.sqrt(2.0) * RMS.value
    x = {v.name: 0.0 for v in found.states}
    h, added = PERIOD / n, []
    for k in range(n_periods * n):
        angle = 2.0 * math.pi * k * h
        s = Signals(
            position=AMPLITUDE * math.sin(angle),
            velocity=2.0 * math.pi * AMPLITUDE * math.cos(angle),
            load=100.0,
        )
        value = size * math.sin(angle)
        applied = found.law(k * h, value, s, SimpleNamespace(**x), p, PYTHON)
        added.append(applied.value - value)
        x = {name: value + h * applied.changes[name] for name, value in x.items()}
    return np.array(added[-n:])


def typical(found):
    return {v.name: v.start for v in found.parameters} | dict(found.scale(RMS)) | dict(found.variants[0])


AT_LIMITS = [
    ("stribeck", {"breakaway": 0.0}),
    ("stribeck", {"stribeck_velocity": 1e-5}),
    ("stribeck", {"stribeck_velocity": 1.0}),
    ("asymmetric_friction", {"forward": 5.0, "backward": 5.01, "damping_difference": 0.0}),
    ("dahl", {"length": 5e-6}),
    ("bouc_wen", {"length": 5e-6}),
    ("presliding", {"stiffness": 2e6, "forward": 5.0, "backward": 3.0}),
    ("warm_up", {"time_constant": 200.0}),
    ("warm_up", {"time_constant": 5e-3}),
    ("missing_codes", {"share": 0.9995}),
    ("ageing_contacts", {"level": 5.0, "direct": 0.0, "evolution": 1e-3}),
]


@pytest.mark.parametrize(("name", "values"), AT_LIMITS)
def test_a_law_at_its_limit_is_the_law_that_it_says(name, values):
    own = effect(name)
    given = typical(own) | values
    limit = own.limit(given, RMS)
    other = effect(limit.becomes)
    same = typical(other) | {"smoothing": 1e-3} | dict(limit.values(given))
    n = 10 * N if own.has_memory else N  # a short way is short in time, too
    expected = force(other, {v.name: same[v.name] for v in other.parameters}, n=n)

    rest = force(own, given, n=n) - expected
    bound = 0.15 if own.has_memory else 0.06  # the force turns after the motion, by 2 % of the time
    assert np.sqrt(np.mean(rest**2)) < bound * np.sqrt(np.mean(expected**2))


LINEAR_LIMITS = [
    ("coulomb", {"level": 5.0, "smoothing": 1.0}, {"velocity": 5.0}),
    ("dahl", {"level": 5.0, "length": 0.2}, {"position": 25.0}),
    ("bouc_wen", {"level": 5.0, "length": 0.2}, {"position": 25.0}),
    ("presliding", {"stiffness": 100.0, "forward": 50.0, "backward": 50.0}, {"position": 100.0}),
    ("end_stop", {"limit": 0.0, "stiffness": 300.0}, {"position": 300.0}),
    ("clearance", {"gap": 0.05, "stiffness": 300.0}, {"position": -300.0}),
    ("magnet", {"pull": 5.0, "gap": 0.8, "side": -1.0}, {"position": -12.5}),
    ("relaxation", {"stiffness": 300.0, "time_constant": 2e-3}, {"velocity": 0.6}),
    ("relaxation", {"stiffness": 300.0, "time_constant": 20.0}, {"position": 300.0}),
    ("squeeze_film", {"coefficient": 5.0, "gap": 1.0}, {"velocity": 5.0}),
    ("power_law", {"amplitude": 5.0, "exponent": 0.99, "reference": 0.01}, {"position": 500.0}),
]


@pytest.mark.parametrize(("name", "values", "coefficients"), LINEAR_LIMITS)
def test_a_law_at_its_limit_is_a_spring_or_a_damper(name, values, coefficients):
    own = effect(name)
    limit = own.limit(typical(own) | values, RMS)
    angle = 2.0 * np.pi * np.arange(N) / N
    expected = coefficients.get("position", 0.0) * AMPLITUDE * np.sin(angle)
    expected += coefficients.get("velocity", 0.0) * 2.0 * np.pi * AMPLITUDE * np.cos(angle)

    found = force(own, typical(own) | values)
    assert limit.becomes is None
    rest = found - found.mean() - expected
    assert np.sqrt(np.mean(rest**2)) < 0.06 * np.sqrt(np.mean(expected**2))


@pytest.mark.parametrize("name", [n for n, e in listed().items() if e.limits])
def test_a_law_of_typical_size_is_at_no_limit(name):
    assert effect(name).limit(typical(effect(name)), RMS) is None


def test_every_limit_is_tried():
    tried = {n for n, _ in AT_LIMITS} | {n for n, _, _ in LINEAR_LIMITS}
    others = [effect(n).limit(typical(effect(n)) | v, RMS) for n, v in AT_LIMITS] + [
        effect(n).limit(typical(effect(n)) | v, RMS) for n, v, _ in LINEAR_LIMITS
    ]

    assert tried == {n for n, e in listed().items() if e.limits}
    assert {id(limit) for e in listed().values() for limit in e.limits} == {id(limit) for limit in others}


@pytest.mark.parametrize("name", listed())
def test_the_name_of_an_effect_does_not_split_the_name_of_a_model(name):
    assert AND not in f"_{name}_"
    assert SEPARATOR not in name


def test_names_of_other_effects_exist():
    for found in listed().values():
        for name in (*found.equals_sum_of, *(limit.becomes for limit in found.limits if limit.becomes)):
            assert effect(name).name == name


def test_asymmetric_friction_is_coulomb_friction_and_an_offset():
    own = effect("asymmetric_friction")
    assert own.equals_sum_of == ("coulomb", "offset")

    given = {"forward": 7.0, "backward": 3.0, "damping_difference": 0.0, "smoothing": 1e-4}
    rest = force(own, given) - force(effect("coulomb"), {"level": 5.0, "smoothing": 1e-4}) - 2.0
    assert np.sqrt(np.mean(rest**2)) < 0.02 * 5.0


@pytest.mark.parametrize("name", listed())
def test_a_law_with_states_has_memory_and_no_other(name):
    found = effect(name)
    assert found.has_memory is (name not in WITHOUT_MEMORY)


WITHOUT_MEMORY = {
    *(
        "asymmetric_friction",
        "clearance",
        "coulomb",
        "cubic_stiffness",
        "drift",
        "end_stop",
        "force_saturation",
    ),
    *("gain_error", "load_friction", "offset", "quadratic_damping", "quadratic_stiffness", "quantisation"),
    *("ripple", "slack", "stribeck", "dead_zone", "magnet", "missing_codes", "one_sided_saturation"),
    *("parametric_stiffness", "second_stage", "warm_up", "overflow", "power_law", "squeeze_film"),
    "structural_damping",
}


@pytest.mark.parametrize("name", [n for n, e in listed().items() if not e.has_memory and e.amplitudes])
def test_a_law_is_linear_in_its_amplitudes(name):
    """Twice all of them adds twice as much, where the law answers in proportion at all."""
    found = effect(name)
    if found.probe == 1.0 or found.first_guess is FirstGuess.QUANTA:
        pytest.skip("answers at full size only")
    once = typical(found)
    twice = once | {n: 2.0 * once[n] for n in found.amplitudes}
    value, s = 50.0, Signals(position=0.02, velocity=0.03, load=80.0)
    one, two = (
        found.law(1.0, value, s, None, SimpleNamespace(**p), PYTHON).value - value for p in (once, twice)
    )

    assert two == pytest.approx(2.0 * one, rel=1e-12)


def test_amplitudes_and_shapes_of_some():
    assert effect("stribeck").amplitudes == ("level", "breakaway")
    assert effect("slack").amplitudes == ()
    assert effect("ripple").amplitudes == ("sine", "cosine")
    assert effect("end_stop").amplitudes == ("stiffness",)


@pytest.mark.parametrize("name", ["force_saturation", "one_sided_saturation", "rate_saturation"])
def test_a_law_that_is_probed_at_full_size_does_nothing_below(name):
    """A fiftieth of a signal's size is no limit for it."""
    found = effect(name)
    assert found.probe == 1.0
    assert found.absent["limit"] >= 1e9


def test_the_constant_is_what_the_law_adds():
    found = constant()
    applied = found.law(0.3, 7.0, Signals(), None, SimpleNamespace(**{found.constant: 2.5}), PYTHON)

    assert [v.name for v in found.parameters] == [found.constant]
    assert applied.value == 9.5


def test_effects_that_act_like_a_lag_delay_a_slow_sine():
    assert {n for n, e in listed().items() if e.acts_like == "lag"} == {
        "extra_lag",
        "extra_delay",
        "end_effector_inertia",
        "mount_resonance",
    }


def test_every_experiment_but_the_last_shows_two_effects_at_least():
    for experiment in [e for e in Experiment if e is not Experiment.OTHER_AMPLITUDE]:
        assert sum(experiment in e.shown_by for e in listed().values()) >= 2

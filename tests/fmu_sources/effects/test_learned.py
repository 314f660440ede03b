from __future__ import annotations

import math
from types import SimpleNamespace

import numpy as np
import pytest

from fmu_sources.composed.composition import with_effect
from fmu_sources.effects.catalogue import effect
from fmu_sources.effects.framework.roles import Signals
from fmu_sources.effects.learned import CENTRES, WIDTHS, coefficients, harmonics, learned, play_rate, splines
from fmu_sources.framework.arithmetic import PYTHON
from fmu_sources.framework.instance import Instance


def parameters(first, c, d):
    """Coefficients c(i), d(i) of the functions, half ranges 0.02 and 0.5."""
    names = coefficients(first)
    n = len(names) // 2
    values = {name: (c, d)[i // n](i % n) for i, name in enumerate(names)}
    return SimpleNamespace(**values, half_range_a=0.02, half_range_b=0.5, memory_time=0.1)


def nothing(_):
    return 0.0


@pytest.mark.parametrize("share", [-1.0, -0.77, 0.0, 0.3, 0.99, 1.0, 4.0])
def test_splines_sum_to_one(share):
    assert sum(splines(share, PYTHON)) == pytest.approx(1.0, abs=1e-14)


@pytest.mark.parametrize(("position", "velocity"), [(0.0, 0.0), (0.004, -0.3), (-0.02, 0.5)])
def test_linear_coefficients_give_a_bilinear_law(position, velocity):
    s = Signals(position=position, velocity=velocity)
    p = parameters("position", lambda i: 3.0 * CENTRES[i], lambda i: 2.0 * CENTRES[i])

    found = effect("learned_position_velocity").law(0.0, 1.0, s, None, p, PYTHON).value

    a, b = position / 0.02, velocity / 0.5
    assert found == pytest.approx(1.0 + 3.0 * a + 2.0 * a * b)


def test_law_is_held_beyond_its_range():
    law, p = effect("learned_position_velocity").law, parameters("position", lambda i: CENTRES[i], nothing)

    values = [law(0.0, 0.0, Signals(position=r, velocity=0.0), None, p, PYTHON).value for r in (0.02, 5.0)]

    assert values == pytest.approx([1.0, 1.0])


def test_friction_that_changes_along_the_position_has_the_sign_of_the_motion():
    law, p = effect("learned_position_sign").law, parameters("position", nothing, lambda i: 1.0 + CENTRES[i])

    values = [law(0.0, 0.0, Signals(position=0.01, velocity=v), None, p, PYTHON).value for v in (20.0, -20.0)]

    assert values == pytest.approx([1.5, -1.5])


def test_memory_is_the_way_since_the_lagged_value():
    found = learned("value", "memory")
    p = parameters("value", nothing, lambda _: 1.0)

    applied = found.law(0.0, 0.3, Signals(), SimpleNamespace(lagged=0.1), p, PYTHON)

    assert applied.value == pytest.approx(0.3 + 0.2 / 0.5)
    assert applied.changes == pytest.approx({"lagged": 2.0})
    assert found.follows == ("lagged",)


def test_harmonics_repeat_after_a_period():
    first, later = harmonics(0.3, 0.7, PYTHON), harmonics(1.0, 0.7, PYTHON)

    assert first == pytest.approx(later)
    assert first[1] == pytest.approx(math.cos(2.0 * math.pi * 0.3 / 0.7))


def test_play_stays_in_its_width_and_follows_inside():
    play = 0.0
    for velocity in [1.0] * 400 + [-1.0] * 30:
        play += 1e-3 * play_rate(velocity, play, 0.1, PYTHON)

    assert play == pytest.approx(0.1 - 0.03, abs=0.002)


def test_widest_play_is_the_half_range():
    assert WIDTHS[-1] == 1.0
    assert np.all(np.diff(WIDTHS) > 0.0)


@pytest.mark.parametrize("name", ["learned_position_velocity", "learned_velocity_position"])
def test_learned_effect_joins_a_model(oscillator, name):
    instance = Instance(with_effect(oscillator, "spring", effect(name)))
    for coefficient in ("c_10", "c_11", "c_12"):
        instance[f"spring_{name}_{coefficient}"] = 1.0
    plain = Instance(oscillator)
    for one in (instance, plain):
        one.initialise()
        one.step(0.0, 1e-3)

    assert instance["f"] > plain["f"] + 0.5


def test_learned_effect_of_the_value_joins_a_sensor(oscillator):
    model = with_effect(oscillator, "sensor", effect("learned_value_memory"))

    assert "sensor_learned_value_memory_d_21" in {v.name for v in model.all_variables}

from __future__ import annotations

from types import SimpleNamespace

import pytest

from fmu_sources.arithmetic import PYTHON
from fmu_sources.composition import with_effect
from fmu_sources.effects.catalogue import effect
from fmu_sources.effects.learned import CENTRES, COEFFICIENTS, N_SPLINES, learned, splines
from fmu_sources.effects.roles import Signals
from fmu_sources.instance import Instance


def parameters(coefficient):
    places = [(i, j) for i in range(N_SPLINES) for j in range(N_SPLINES)]
    values = {n: coefficient(CENTRES[i], CENTRES[j]) for n, (i, j) in zip(COEFFICIENTS, places, strict=True)}
    return SimpleNamespace(**values, half_range_a=0.02, half_range_b=0.5, memory_time=0.1)


@pytest.mark.parametrize("share", [-1.0, -0.77, 0.0, 0.3, 0.99, 1.0, 4.0])
def test_splines_sum_to_one(share):
    assert sum(splines(share, PYTHON)) == pytest.approx(1.0, abs=1e-14)


@pytest.mark.parametrize(("position", "velocity"), [(0.0, 0.0), (0.004, -0.3), (-0.02, 0.5)])
def test_linear_coefficients_give_a_linear_law(position, velocity):
    s, p = Signals(position=position, velocity=velocity), parameters(lambda a, b: 3.0 * a + 2.0 * b)

    found = effect("learned_position_velocity").law(0.0, 1.0, s, None, p, PYTHON).value

    assert found == pytest.approx(1.0 + 3.0 * position / 0.02 + 2.0 * velocity / 0.5)


def test_law_is_held_beyond_its_range():
    law, p = effect("learned_position_velocity").law, parameters(lambda a, b: a)

    values = [law(0.0, 0.0, Signals(position=r, velocity=0.0), None, p, PYTHON).value for r in (0.02, 5.0)]

    assert values == pytest.approx([1.0, 1.0])


def test_memory_is_the_way_since_the_lagged_position():
    found = learned("velocity", "memory")
    s, x = Signals(position=0.3, velocity=0.0), SimpleNamespace(lagged=0.1)

    applied = found.law(0.0, 0.0, s, x, parameters(lambda a, b: b), PYTHON)

    assert applied.value == pytest.approx(0.2 / 0.5)
    assert applied.changes == pytest.approx({"lagged": 2.0})
    assert found.needs == ("velocity", "position")


@pytest.mark.parametrize("name", ["learned_position_velocity", "learned_velocity_memory"])
def test_learned_effect_joins_a_model(oscillator, name):
    instance = Instance(with_effect(oscillator, "spring", effect(name), starts={"c_4_4": 1.0}))
    instance.initialise()
    instance.step(0.0, 1e-3)

    assert instance["f"] > 16.0


def test_learned_effect_of_the_value_joins_a_sensor(oscillator):
    model = with_effect(oscillator, "sensor", effect("learned_value_memory"))

    assert "sensor_learned_value_memory_c_7_7" in {v.name for v in model.all_variables}

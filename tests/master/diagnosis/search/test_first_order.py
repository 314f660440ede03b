"""Laws evaluated on a slot's signals instead of being built: what they add, and where that is not known."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from master.diagnosis.numerics.least_squares import Fit
from master.diagnosis.replay.placed_effect import PlacedEffect
from master.diagnosis.search.extended_model import ExtendedModel
from master.diagnosis.search.first_order import FirstOrder

PERIOD = 1e-3
T = PERIOD * np.arange(2000)
X = 0.02 * np.sin(3.0 * T)
V = 0.06 * np.cos(3.0 * T)
FORCE = 400.0 * X
ROPE = "box.rope"
SENSOR = "box.output"


class Doubling:
    """The output is twice what is added."""

    is_linear = True

    def answer(self, functions):
        return 2.0 * functions[:, None, :]


@pytest.fixture
def known(study_of):
    """Two recordings of one second each; slots of a force and of a reading."""

    def make(chosen=(), values=None, sample_time=None):
        lengths = {"first": np.zeros(1000), "second": np.zeros(1000)}
        bench = SimpleNamespace(
            measured=np.zeros((2000, 1)),
            is_windowed=False,
            recordings=lengths,
            first_sample={"first": 0, "second": 1000}.__getitem__,
            times=T,
            period=PERIOD,
        )
        system = SimpleNamespace(model=lambda fmu: SimpleNamespace(sample_time=sample_time))
        study = study_of(np.zeros((2000, 1)), [slice(0, 100)], bench=bench, system=system)
        signals = {ROPE: {"value": FORCE, "position": X, "velocity": V}, SENSOR: {"value": FORCE}}
        study.__dict__["signals"] = signals
        study.__dict__["slot_signals_with"] = lambda model, values, place: signals[place]
        fitted = Fit("x", values or {}, {}, np.zeros((2000, 1)), 0.0)
        found = FirstOrder(study, ExtendedModel(tuple(chosen)), fitted)
        found._injections.update({ROPE: Doubling(), SENSOR: Doubling()})
        return found

    return make


def test_a_law_without_states_adds_what_its_formula_says(known):
    cubic = PlacedEffect("box", "rope", "cubic_stiffness")
    (name,) = (cubic.variable(v.name) for v in cubic.law.parameters if v.name in cubic.law.amplitudes)

    assert known().covers(cubic, {name: 5e4})
    assert known().change(cubic, {name: 5e4})[:, 0] == pytest.approx(2.0 * 5e4 * X**3, rel=1e-9)


def test_a_lag_starts_at_the_value_in_each_recording(known):
    lag = PlacedEffect("box", "output", "extra_lag")
    values = {lag.variable("time_constant"): 0.05}

    assert known().covers(lag, values)
    change = known().change(lag, values)[:, 0]

    assert change[0] == pytest.approx(0.0, abs=1e-12)
    assert change[1000] == pytest.approx(0.0, abs=1e-12)
    settled = change[500:1000]
    steady = 8.0 * np.imag(np.exp(3.0j * T[500:1000]) / (1.0 + 0.05 * 3.0j))
    assert settled == pytest.approx(2.0 * (steady - FORCE[500:1000]), abs=2e-3)


def test_an_effect_after_another_in_its_slot_sees_what_that_returns(known):
    """Half as much again of a value to which 3 was added: 3 / 2 more than of the value itself."""
    offset = PlacedEffect("box", "output", "offset")
    gain = PlacedEffect("box", "output", "gain_error")
    change = known([offset], {offset.variable("offset"): 3.0}).change(gain, {gain.variable("error"): 0.5})

    assert change[:, 0] == pytest.approx(2.0 * 0.5 * (FORCE + 3.0))


def test_friction_with_memory_has_to_be_replayed_and_so_has_all_after_it(known):
    dahl = PlacedEffect("box", "rope", "dahl")
    coulomb = PlacedEffect("box", "rope", "coulomb")

    assert not known().covers(dahl, {})
    assert known().covers(coulomb, {})
    assert not known([dahl]).covers(coulomb, {})
    assert known([dahl]).covers(PlacedEffect("box", "output", "offset"), {})


def test_a_law_with_states_in_a_sampled_model_has_to_be_replayed(known):
    lag = PlacedEffect("box", "output", "extra_lag")

    assert not known(sample_time="T").covers(lag, {lag.variable("time_constant"): 0.05})

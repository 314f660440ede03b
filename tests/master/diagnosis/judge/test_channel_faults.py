"""Faults of a channel by themselves: each is found with its number, and none in noise."""

from __future__ import annotations

import numpy as np
import pytest

from master.diagnosis.adequacy.channels import Adequacy, Kind, Predictor
from master.diagnosis.judge.channel_faults import channel_faults, is_best
from master.diagnosis.numerics.folds import Share
from master.diagnosis.numerics.noise_floor import Colour, Evidence, NoiseFloor
from master.diagnosis.numerics.whiteness import Interval

N = 5000
T = np.arange(N) * 1e-3
MODEL = 3.0 * np.sin(2.0 * np.pi * 1.3 * T) + np.sin(2.0 * np.pi * 4.1 * T)
NOISE = 0.1 * np.random.default_rng(1).standard_normal(N)


def found(measured):
    return channel_faults("a.f", measured, MODEL, 1e-3, "N")


def test_noise_is_no_fault():
    assert found(MODEL + NOISE) == []


def test_a_zero_error_is_called_that_with_its_unit():
    [fault] = found(MODEL + 2.0 + NOISE)

    assert fault.kind == "zero error"
    assert abs(fault.value - 2.0) < 4.0 * fault.deviation
    assert str(fault).startswith("channel a.f: zero error 2.00") or str(fault).startswith(
        "channel a.f: zero error 1.99"
    )
    assert str(fault).endswith(" N")


def test_gain_and_a_fraction_of_a_tick_of_delay_have_their_numbers():
    late = np.interp(T - 0.4e-3, T, MODEL)

    assert found(1.1 * MODEL + NOISE)[0].value == pytest.approx(0.1, abs=0.01)
    assert found(late + 0.05 * NOISE)[0].kind == "delay"
    assert found(late + 0.05 * NOISE)[0].value == pytest.approx(0.4e-3, abs=0.05e-3)


def test_a_logger_that_is_four_milliseconds_late():
    late = np.concatenate([np.full(4, MODEL[0]), MODEL[:-4]])

    [fault] = found(late + 0.1 * NOISE)

    assert (fault.kind, fault.value) == ("delay", pytest.approx(4e-3))
    assert str(fault) == "channel a.f: 4 +- 0.5 ms late"


def test_the_other_way_round_and_another_unit_are_told():
    assert str(found(-MODEL + NOISE)[0]).startswith("channel a.f: the other way round")
    assert str(found(617.0 * MODEL)[0]) == "channel a.f: 617 times the model"


@pytest.mark.parametrize(("predicted", "is_told"), [(0.0, True), (0.35, True), (0.6, False)])
def test_a_fault_is_told_where_nothing_explains_much_more(predicted, is_told):
    """A delay that explains a third of what is left is none if something else explains much more."""
    late = np.interp(T - 0.4e-3, T, MODEL)
    [fault] = found(late + 0.15 * NOISE)
    share = Share(predicted, Interval(max(0.0, predicted - 0.05), predicted))
    left = Adequacy(
        "a.f",
        1.0,
        NoiseFloor(0.1, Evidence.REST),
        0.0,
        (Predictor(Kind.TREES, "", share),),
        Colour(0.0, (), 0),
    )

    assert fault.share == pytest.approx(0.32, abs=0.01)
    assert is_best(fault, left) is is_told

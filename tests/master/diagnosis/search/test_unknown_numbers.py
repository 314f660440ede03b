"""A parameter whose interval holds nearly all that it could be has no number."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from fmu_sources.effects.framework.effect import Rms
from master.diagnosis.numerics.least_squares import Fit, FreeParameter
from master.diagnosis.replay.placed_effect import PlacedEffect, free_parameters
from master.diagnosis.search.extended_model import ExtendedModel
from master.diagnosis.search.unknown_numbers import of_effect, unknown_numbers

OVERFLOW = PlacedEffect("tanks", "upper_outflow", "overflow")
SINE = np.sin(np.linspace(0.0, 20.0, 500))
RMS = Rms(value=70.0, position=3.5, velocity=0.035, load=1.0, duration=10.0)


def study(base=()):
    signals = {"value": 100.0 * SINE, "position": 5.0 * SINE, "velocity": 0.05 * SINE}
    return SimpleNamespace(
        base=tuple(base),
        signals={OVERFLOW.place: signals},
        bench=SimpleNamespace(period=1e-3),
        signal_rms=lambda place: RMS,
    )


def unknown(placed, values, deviations, base=()):
    model = ExtendedModel().with_effect(placed, {}, free_parameters(placed, RMS))
    names = {placed.variable(k): v for k, v in values.items()}
    known = {placed.variable(k): v for k, v in deviations.items()}
    known |= {p.name: 2.0e4 for p in base}
    names |= {p.name: p.start for p in base}
    fit = Fit("overflow", names, known, np.zeros((1, 1)), 1.0)
    return unknown_numbers(study(base), model, fit)


@pytest.mark.parametrize("deviation", [2500.0, 4.9])
def test_an_edge_known_worse_than_all_levels_that_were_recorded_has_no_number(deviation):
    found = unknown(OVERFLOW, {"amplitude": 4.0, "edge": 2.0}, {"amplitude": 0.1, "edge": deviation})

    half = {2500.0: "4.9e+03", 4.9: "9.6"}[deviation]
    why = f"its 95 % interval of +- {half} around 2 holds nearly all that it could be"
    assert of_effect(OVERFLOW, found) == {"edge": why}


def test_an_edge_known_to_a_tenth_of_the_levels_has_one():
    assert unknown(OVERFLOW, {"amplitude": 4.0, "edge": 2.0}, {"amplitude": 0.1, "edge": 0.5}) == {}


def test_a_size_within_little_of_nothing_is_a_number_and_one_that_may_be_its_double_is_none():
    """Its typical size is 0.05 * 70 = 3.5."""
    edge = {"edge": 0.5}

    assert unknown(OVERFLOW, {"amplitude": 0.0, "edge": 2.0}, {"amplitude": 0.1} | edge) == {}
    found = unknown(OVERFLOW, {"amplitude": 4.0, "edge": 2.0}, {"amplitude": 2.2} | edge)
    assert list(of_effect(OVERFLOW, found)) == ["amplitude"]


def test_what_no_row_depends_on_has_no_number():
    found = unknown(OVERFLOW, {"amplitude": 4.0, "edge": 2.0}, {"amplitude": 0.1, "edge": np.inf})

    assert found == {OVERFLOW.variable("edge"): "nothing recorded depends on it"}


@pytest.mark.parametrize(("high", "has_number"), [(2.8e5, True), (1.1e5, False)])
def test_a_parameter_of_the_system_has_none_where_its_interval_holds_its_bounds(high, has_number):
    """+- 39 000 around 100 000."""
    base = FreeParameter("contact.k_m", 1.0e5, 7.0e4, high, 1.0e5)

    found = unknown(OVERFLOW, {"amplitude": 4.0, "edge": 2.0}, {"amplitude": 0.1, "edge": 0.5}, [base])

    assert ("contact.k_m" not in found) is has_number


def test_a_damping_next_to_nothing_is_a_number_where_its_bounds_leave_much_more():
    """It is within 0 and 39 000 of up to 600 000."""
    base = FreeParameter("contact.c_m", 1.0, 0.0, 6.0e5, 1.0)

    assert unknown(OVERFLOW, {"amplitude": 4.0, "edge": 2.0}, {"amplitude": 0.1, "edge": 0.5}, [base]) == {}

"""Screening on a model that is linear in its parameters: y = k x + c v + effects."""

from __future__ import annotations

import numpy as np
import pytest

from fmu_sources.effects.framework.effect import Rms
from master.diagnosis.numerics.least_squares import FAR, Fit, FreeParameter
from master.diagnosis.numerics.regression import Background
from master.diagnosis.replay.placed_effect import PlacedEffect
from master.diagnosis.search.extended_model import ExtendedModel
from master.diagnosis.search.screening import screened
from master.diagnosis.search.study import Study
from master.diagnosis.search.tangent import Tangent

N = 600
T = np.arange(N) * 1e-2
X = np.sin(2.0 * T)
V = 2.0 * np.cos(2.0 * T)
OFFSET = PlacedEffect("box", "output", "offset")
GAIN = PlacedEffect("box", "output", "gain_error")
BASE = (FreeParameter("box.k", 3.0, scale=3.0), FreeParameter("box.c", 0.5, scale=0.5, spread=0.1))


def predicted(effects, values):
    y = values["box.k"] * X + values["box.c"] * V
    if GAIN in effects:
        y = y * (1.0 + values[GAIN.variable("error")])
    if OFFSET in effects:
        y = y + values[OFFSET.variable("offset")]
    return y[:, None]


@pytest.fixture
def study(study_of, monkeypatch):
    """What was measured has an offset of 0.25 that the model lacks; the scale of the output is 0.1."""

    def simulate(self, effects, values, everything=False):
        return predicted(effects, values)

    monkeypatch.setattr(Study, "simulate", simulate)
    monkeypatch.setattr(Study, "signal_rms", lambda self, place: Rms(value=2.0))
    measured = predicted((), {"box.k": 3.0, "box.c": 0.5}) + 0.25
    rows = np.arange(N) < 400
    return study_of(measured, [slice(400, 600)], base=BASE, fit_rows=rows, output_scale=np.array([0.1]))


@pytest.fixture
def base():
    values = {"box.k": 3.0, "box.c": 0.5}
    return Fit("base", values, {}, predicted((), values), 0.0)


def test_tangent_holds_residual_sensitivities_and_priors(study, base):
    tangent = Tangent(study, ExtendedModel(), base)

    assert tangent.residual == pytest.approx(np.full(400, 2.5))
    assert tangent.known["box.k"] == pytest.approx(3.0 * X[:400] / 0.1, rel=1e-8)
    assert tangent.known["box.c"] == pytest.approx(0.5 * V[:400] / 0.1, rel=1e-8)
    assert np.array_equal(tangent.prior, np.diag([0.0, 5.0]))
    assert tangent.prior_left.tolist() == [0.0, 0.0]


def test_response_of_an_effect_is_its_change_of_the_outputs(study, base):
    tangent = Tangent(study, ExtendedModel(), base)
    model = ExtendedModel((OFFSET,))

    response = tangent.response(model, {OFFSET.variable("offset"): 0.05})

    assert response == pytest.approx(np.full(400, 0.5))
    gain = tangent.gain([response], [-np.inf])
    assert gain.share == pytest.approx(1.0)
    assert gain.factors == pytest.approx([5.0])


def test_screening_finds_the_effect_and_its_size(study, base):
    best, *_ = screened(study, ExtendedModel(), base, [GAIN, OFFSET])

    assert best.model.effects == (OFFSET,)
    assert best.gain == pytest.approx(1.0)
    assert best.starts[0][OFFSET.variable("offset")] == pytest.approx(0.25, rel=1e-6)
    assert set(best.known) == {"box.k", "box.c"}


def test_a_response_that_runs_away_promises_nothing(study, base):
    """Regressed on, an unstable replay takes away what it is large for: a few rows at its end."""
    tangent = Tangent(study, ExtendedModel(), base)
    steady = tangent.residual.copy()
    unstable = np.clip(2.0 ** np.arange(len(steady)), 0.0, FAR)

    assert tangent.gain([steady], [0.0]).share > 0.9
    assert np.isnan(tangent.gain([unstable], [0.0]).share)
    assert np.isnan(tangent.gain([steady, unstable], [0.0, 0.0]).share)


def test_an_effect_after_another_in_its_slot_sees_what_that_returns(study, base):
    chosen = ExtendedModel((OFFSET,), {}, (FreeParameter(OFFSET.variable("offset"), 0.25, scale=0.25),))
    values = dict(base.values) | {OFFSET.variable("offset"): 0.25}
    tangent = Tangent(study, chosen, Fit("x", values, {}, predicted((OFFSET,), values), 0.0))

    model = ExtendedModel((OFFSET, GAIN))
    response = tangent.response(model, {GAIN.variable("error"): 0.1})

    exact = predicted((OFFSET, GAIN), values | {GAIN.variable("error"): 0.1}) - predicted((OFFSET,), values)
    assert response == pytest.approx(exact[:400, 0] / 0.1)
    assert tangent.power == pytest.approx(0.0, abs=1e-12)


def test_a_factor_below_its_bound_is_left_out_by_hand():
    """Residual (3, -2) on two responses (1, 0) and (0, 1) of which none may be negative."""
    none = np.zeros((0, 0))
    background = Background(np.array([3.0, -2.0]), [], none, np.zeros(0))
    result = background.regressed([np.array([1.0, 0.0]), np.array([0.0, 1.0])], [0.0, 0.0])

    assert result.factors.tolist() == pytest.approx([3.0, 0.0])
    assert result.power == pytest.approx(4.0)


def test_a_prior_pulls_a_free_column_by_hand():
    """Minimise (1 - a)^2 + (0 - a)^2: a = 1/2, and 1/2 is left."""
    result = Background(np.array([1.0]), [np.array([1.0])], np.eye(1), np.zeros(1)).regressed([], [])

    assert result.power == pytest.approx(0.5)


def test_a_response_beside_what_is_fitted_already_is_regressed_on_together_with_it():
    """By hand: (2, 3) on (1, 1) and (0, 1) is met by 2 and 1; twice (1, 1) has nothing of its own."""
    background = Background(np.array([2.0, 3.0]), [np.ones(2)], np.zeros((1, 1)), np.zeros(1))

    other = background.regressed([np.array([0.0, 1.0])], [0.0])
    same = background.regressed([np.array([2.0, 2.0])], [0.0])

    assert other.factors == pytest.approx([1.0])
    assert other.power == pytest.approx(0.0, abs=1e-12)
    assert same.factors.tolist() == [0.0]
    assert same.power == pytest.approx(background.power) == pytest.approx(0.5)


def test_a_study_does_not_change_after_it_was_made(study):
    with pytest.raises(AttributeError):
        study.output_scale = np.ones(1)


def test_what_an_effect_promises_is_asked_for_on_rows_that_it_was_not_sized_on(study, base):
    """Measured less the base is 0.25 on all rows: an offset takes all of it, a gain nothing that lasts."""
    found = {
        s.model.effects[-1]: s
        for s in screened(study, ExtendedModel(), base, [GAIN, OFFSET], is_held_out=True)
    }

    assert found[OFFSET].held_out == pytest.approx(1.0)
    assert found[GAIN].held_out < 0.02


def test_an_offset_of_the_fitted_rows_alone_promises_nothing_on_the_others(study, base):
    """Fitted rows are 0.25 too high, held-out ones 0.25 too low: there the offset doubles what is left."""
    study.measured[400:] -= 0.5

    offset, *_ = screened(study, ExtendedModel(), base, [OFFSET], is_held_out=True)

    assert offset.gain == pytest.approx(1.0)
    assert offset.held_out < -2.0

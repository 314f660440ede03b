"""Of what cannot be told apart, a member leads that nothing speaks against. Static fits stand for replays."""

from __future__ import annotations

import numpy as np
import pytest

from fmu_sources.effects.framework.effect import Rms
from master.diagnosis.numerics.least_squares import Fit
from master.diagnosis.replay.placed_effect import PlacedEffect, free_parameters
from master.diagnosis.search.extended_model import ExtendedModel
from master.diagnosis.search.families import Ranked
from master.diagnosis.search.leading import led_by_the_unobjected
from master.diagnosis.search.rounds import Round, SearchResult
from master.diagnosis.search.study import Study

N = 1200
BLOCKS = [slice(100 * i, 100 * (i + 1)) for i in range(12)]
NOISE = np.random.default_rng(2).standard_normal((N, 1))
POSITION = 5e-3 * np.sin(np.arange(N) / 50.0)
SIGNALS = {"value": 100.0 * POSITION, "position": POSITION, "velocity": np.gradient(POSITION, 1e-3)}
RMS = Rms(value=70.0, position=3.5e-3, velocity=0.035, load=1.0, duration=10.0)
SLACK, MAGNET = (PlacedEffect("contact", "rope_force", name) for name in ("slack", "magnet"))
BEYOND = {SLACK.variable("limit"): 2e-2, SLACK.variable("width"): 1e-3}
WITHIN = BEYOND | {SLACK.variable("limit"): 3e-3}
PULL = {MAGNET.variable("pull"): 2.3, MAGNET.variable("gap"): 1.3e-2}


def fit(error, values, *, at_bound=(), deviation=0.01):
    """Fit that misses what was measured by an error, with deviations as shares of its values."""
    predicted = NOISE + error * np.sin(np.arange(N))[:, None]
    deviations = {k: deviation * v for k, v in values.items()}
    return Fit("x", values, deviations, predicted, 0.0, 0, at_bound)


def model(placed):
    return ExtendedModel().with_effect(placed, {placed.variable("side"): 1.0}, free_parameters(placed, RMS))


@pytest.fixture
def leader(study_of, monkeypatch):
    """Find what leads where slack led a magnet, by fits of both that cannot be told apart or can."""

    def find(slack, magnet):
        monkeypatch.setattr(Study, "fitted", lambda *_: magnet)
        monkeypatch.setattr(Study, "build", lambda *_: None)
        monkeypatch.setattr(Study, "signal_rms", lambda *_: RMS)
        monkeypatch.setattr(Study, "signals", {SLACK.place: SIGNALS})
        study = study_of(np.zeros((N, 1)), BLOCKS)
        base = fit(10.0, {})
        family = tuple(Ranked(model(e), study.gain(base, f)) for e, f in ((SLACK, slack), (MAGNET, magnet)))
        search = SearchResult(base, model(SLACK), slack, (Round(base, family, family),))
        found = led_by_the_unobjected(study, search)
        assert found.model.effects[-1] == found.rounds[0].family[0].model.effects[-1]
        assert set(found.families[0]) == {str(SLACK), str(MAGNET)}
        return found.model.effects[-1]

    return find


def test_a_law_whose_limit_was_never_reached_leaves_the_lead_to_one_that_explains_as_much(leader):
    assert leader(fit(0.1, BEYOND), fit(0.1, PULL)) == MAGNET


def test_a_law_that_nothing_speaks_against_keeps_the_lead(leader):
    assert leader(fit(0.1, WITHIN), fit(0.1, PULL)) == SLACK


def test_a_law_with_a_number_that_could_be_anything_leaves_the_lead(leader):
    assert leader(fit(0.1, WITHIN, deviation=2.0), fit(0.1, PULL)) == MAGNET


@pytest.mark.parametrize(
    "other",
    [fit(2.0, PULL), fit(0.1, PULL, deviation=2.0), fit(0.1, PULL, at_bound=(MAGNET.variable("gap"),))],
    ids=["explains less", "without numbers", "at a bound"],
)
def test_no_member_leads_that_explains_less_or_is_no_better_founded(leader, other):
    assert leader(fit(0.1, BEYOND), other) == SLACK

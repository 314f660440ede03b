"""Static laws stand for replays: asymmetric friction against Coulomb friction and an offset."""

from __future__ import annotations

import numpy as np
import pytest

from fmu_sources.effects.framework.effect import Rms
from master.diagnosis.numerics.least_squares import Fit
from master.diagnosis.replay.placed_effect import PlacedEffect
from master.diagnosis.search.extended_model import ExtendedModel
from master.diagnosis.search.families import Ranked
from master.diagnosis.search.rounds import Round, SearchResult
from master.diagnosis.search.simplify import with_rewritings
from master.diagnosis.search.study import Study

N = 1200
BLOCKS = [slice(100 * i, 100 * (i + 1)) for i in range(12)]
NOISE = np.random.default_rng(2).standard_normal((N, 1))
ONE = PlacedEffect("contact", "guide_force", "asymmetric_friction")
COULOMB, OFFSET = (
    PlacedEffect("contact", "guide_force", "coulomb"),
    PlacedEffect("sensor", "output", "offset"),
)
ELSEWHERE = PlacedEffect("contact", "rope_force", "coulomb")


def fit(error):
    """Fit that misses what was measured by an error."""
    return Fit("x", {}, {}, NOISE + error * np.sin(np.arange(N))[:, None], 0.0, 0, ())


@pytest.fixture
def decided(study_of, monkeypatch):
    """Result of a search that chose the one law; it and the two leave errors of the given sizes."""

    def make(one, two, candidates=(ONE, COULOMB, OFFSET, ELSEWHERE)):
        def fitted(study, model, *_):
            return fit(two if model.effects == (COULOMB, OFFSET) else np.nan)

        monkeypatch.setattr(Study, "fitted", fitted)
        monkeypatch.setattr(Study, "signal_rms", lambda study, place: Rms())
        study = study_of(np.zeros((N, 1)), BLOCKS)
        base = fit(10.0)
        chosen = ExtendedModel((ONE,))
        winner = Ranked(chosen, study.gain(base, fit(one)))
        step = Round(base, (winner,), (winner,))
        return with_rewritings(study, SearchResult(base, chosen, fit(one), (step,)), candidates)

    return make


def test_two_laws_take_the_place_of_one_where_they_explain_more(decided):
    result = decided(one=1.0, two=0.1)

    assert result.model.effects == (COULOMB, OFFSET)
    assert result.families == []
    assert {p.name for p in result.model.parameters} >= {
        "contact.guide_force_coulomb_level",
        "sensor.output_offset_offset",
    }


def test_one_law_stays_where_two_explain_less(decided):
    result = decided(one=0.1, two=1.0)

    assert result.model.effects == (ONE,)
    assert result.families == []


def test_what_explains_the_same_is_a_family(decided):
    result = decided(one=0.1, two=0.1)

    assert result.model.effects == (ONE,)
    assert result.families == [
        (
            "contact.guide_force: asymmetric_friction",
            "contact.guide_force: coulomb and sensor.output: offset",
        )
    ]


@pytest.mark.parametrize("missing", [COULOMB, OFFSET])
def test_only_what_the_case_thinks_possible_is_tried(decided, missing):
    candidates = [a for a in (ONE, COULOMB, OFFSET, ELSEWHERE) if a != missing]

    assert decided(one=1.0, two=0.1, candidates=candidates).model.effects == (ONE,)

"""Static laws stand for replays: asymmetric friction against Coulomb friction and an offset."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from fmu_sources.effects.framework.effect import Rms
from master.diagnosis.numerics.gains import over
from master.diagnosis.numerics.least_squares import Fit
from master.diagnosis.replay.candidate_models import Added
from master.diagnosis.search.families import Ranked
from master.diagnosis.search.rounds import Found, Round
from master.diagnosis.search.simplify import with_rewritings
from master.diagnosis.search.study import Extended

N = 1200
BLOCKS = [slice(100 * i, 100 * (i + 1)) for i in range(12)]
NOISE = np.random.default_rng(2).standard_normal((N, 1))
ONE = Added("contact", "guide_force", "asymmetric_friction")
COULOMB, OFFSET = Added("contact", "guide_force", "coulomb"), Added("sensor", "output", "offset")
ELSEWHERE = Added("contact", "rope_force", "coulomb")


def fit(error):
    """Fit that misses what was measured by an error."""
    return Fit("x", {}, {}, NOISE + error * np.sin(np.arange(N))[:, None], 0.0, 0, ())


def decided(one, two, wanted=(ONE, COULOMB, OFFSET, ELSEWHERE)):
    """Result of a search that chose the one law; both leave errors of the given sizes."""
    size = np.ones(1)
    study = SimpleNamespace(
        bench=SimpleNamespace(part=SimpleNamespace(name="contact")),
        progress=lambda _: None,
        pool=SimpleNamespace(build=lambda *_: None),
        sizes=lambda _: Rms(),
        held_out=BLOCKS,
        size=size,
        fitted=lambda extended, *_: fit(two if extended.added == (COULOMB, OFFSET) else np.nan),
        gain=lambda before, after: over(before, after, np.zeros((N, 1)), BLOCKS, size),
    )
    base, chosen, found = fit(10.0), Extended((ONE,)), fit(one)
    winner = Ranked(chosen, study.gain(base, found))
    step = Round(base, (winner,), (winner,))
    return with_rewritings(study, Found(base, chosen, found, (step,)), wanted)


def test_two_laws_take_the_place_of_one_where_they_explain_more():
    found = decided(one=1.0, two=0.1)

    assert found.extended.added == (COULOMB, OFFSET)
    assert found.families == []
    assert {p.name for p in found.extended.parameters} >= {
        "contact.guide_force_coulomb_level",
        "sensor.output_offset_offset",
    }


def test_one_law_stays_where_two_explain_less():
    found = decided(one=0.1, two=1.0)

    assert found.extended.added == (ONE,)
    assert found.families == []


def test_what_explains_the_same_is_a_family():
    found = decided(one=0.1, two=0.1)

    assert found.extended.added == (ONE,)
    assert found.families == [
        (
            "contact.guide_force: asymmetric_friction",
            "contact.guide_force: coulomb and sensor.output: offset",
        )
    ]


@pytest.mark.parametrize("missing", [COULOMB, OFFSET])
def test_only_what_the_case_thinks_possible_is_tried(missing):
    wanted = [a for a in (ONE, COULOMB, OFFSET, ELSEWHERE) if a != missing]

    assert decided(one=1.0, two=0.1, wanted=wanted).extended.added == (ONE,)

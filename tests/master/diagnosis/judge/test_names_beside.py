"""Names beside a law without a name: predictions stand for the replays, the fits themselves are played."""

from __future__ import annotations

from dataclasses import dataclass
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from master.diagnosis.judge import names_beside
from master.diagnosis.numerics.least_squares import Fit
from master.diagnosis.replay.placed_effect import PlacedEffect
from master.diagnosis.search.extended_model import ExtendedModel

N, BLOCKS = 2400, [slice(200 * i, 200 * (i + 1)) for i in range(12)]
T = np.linspace(0.0, 6.0, N)
NOISE = 0.5 * np.random.default_rng(1).standard_normal(N)
FRICTION, SPRING = 3.0 * np.sign(np.cos(7.0 * T)), 2.0 * np.sin(7.0 * T) ** 3
LEARNED = PlacedEffect("contact", "rope_force", "learned_position_velocity")
COULOMB = PlacedEffect("contact", "guide_force", "coulomb")


@dataclass(frozen=True)
class Result:
    study: Any
    base: Fit
    chosen: ExtendedModel
    learned: Any
    fit: Fit
    is_named: bool = False


def fitted(predicted):
    return Fit("x", {}, {}, predicted[:, None], 0.0, 0, ())


def judge(is_adequate):
    return SimpleNamespace(judge=lambda predicted, thorough: [SimpleNamespace(is_adequate=is_adequate)])


@pytest.fixture
def beside(study_of, monkeypatch):
    """The effects that stay beside a learned law of the spring, with a fit of both that predicts `both`."""

    def run(truth, both, *, is_adequate=False, is_named=False):
        study = study_of((truth + NOISE)[:, None], BLOCKS)
        base = fitted(np.zeros(N))
        model = ExtendedModel((LEARNED,))
        law = SimpleNamespace(model=model, fit=fitted(SPRING))
        own_fit = fitted(both)
        own = SimpleNamespace(
            model=ExtendedModel((COULOMB, LEARNED)), fit=own_fit, gain=study.gain(base, own_fit)
        )
        candidate = SimpleNamespace(model=ExtendedModel((LEARNED, COULOMB)))
        monkeypatch.setattr(names_beside, "_promising", lambda *_: [candidate])
        monkeypatch.setattr(names_beside, "_fitted", lambda *_: own)
        result = Result(study, base, model, law, law.fit, is_named)
        return names_beside.with_names_beside(result, [COULOMB], judge(is_adequate))

    return run


def test_a_name_that_explains_what_the_law_leaves_stays_beside_it(beside):
    found = beside(SPRING + FRICTION, SPRING + FRICTION)

    assert found.chosen.effects == (COULOMB, LEARNED)
    assert found.learned.model == found.chosen
    assert np.array_equal(found.fit.predicted[:, 0], SPRING + FRICTION)


def test_a_name_that_explains_nothing_more_does_not(beside):
    assert beside(SPRING, SPRING + 0.02 * NOISE[::-1]).chosen.effects == (LEARNED,)


def test_none_is_sought_where_the_law_is_adequate_or_names_were_kept(beside):
    both = SPRING + FRICTION

    assert beside(both, both, is_adequate=True).chosen.effects == (LEARNED,)
    assert beside(both, both, is_named=True).chosen.effects == (LEARNED,)

"""Names against a law without a name: predictions stand for the replays."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from master.diagnosis.judge.named_or_learned import Rivals, is_biased
from master.diagnosis.numerics.least_squares import Fit, FreeParameter
from master.diagnosis.replay.placed_effect import PlacedEffect
from master.diagnosis.search.extended_model import ExtendedModel
from master.diagnosis.search.rounds import SearchResult

N, BLOCKS = 2400, [slice(200 * i, 200 * (i + 1)) for i in range(12)]
T = np.linspace(0.0, 6.0, N)
NOISE = 0.5 * np.random.default_rng(1).standard_normal(N)
FRICTION, SPRING = 3.0 * np.sign(np.cos(7.0 * T)), 2.0 * np.sin(7.0 * T) ** 3


def fitted(predicted):
    return Fit("x", {}, {}, predicted[:, None], 0.0, 0, ())


@pytest.fixture
def rivals(study_of):
    def make(truth, named, alone, both, effects=("coulomb",)):
        study = study_of((truth + NOISE)[:, None], BLOCKS)
        base = fitted(np.zeros(N))
        model = ExtendedModel(tuple(PlacedEffect("contact", "guide_force", e) for e in effects))
        search = SearchResult(base, model, fitted(named), ())
        laws = [SimpleNamespace(fit=fitted(p), gain=study.gain(base, fitted(p))) for p in (alone, both)]
        return Rivals(study, search, alone=laws[0], in_addition=laws[1])

    return make


def test_law_that_explains_what_names_do_not_takes_their_place(rivals):
    assert rivals(SPRING, 0.7 * SPRING, 0.99 * SPRING, 0.99 * SPRING).alone_wins


def test_names_stay_where_the_law_explains_less(rivals):
    assert not rivals(FRICTION, FRICTION, 0.8 * FRICTION, FRICTION).alone_wins


def test_names_stay_with_a_remainder_of_another_kind(rivals):
    both = rivals(FRICTION + SPRING, FRICTION, SPRING, FRICTION + SPRING)

    assert not both.alone_wins
    assert both.named_share == pytest.approx(np.var(FRICTION) / np.var(FRICTION + SPRING), abs=0.1)


def test_names_give_way_to_a_law_to_which_nothing_can_be_added(rivals):
    better = replace(rivals(SPRING, 0.6 * SPRING, SPRING, SPRING), in_addition=None)

    assert better.named_share == pytest.approx(1.0 - 0.4**2, abs=0.02)
    assert better.alone_wins


@pytest.mark.parametrize(
    ("value", "at_bound", "is_far"), [(115.0, (), False), (135.0, (), True), (115.0, ("m",), True)]
)
def test_refit_biases_a_parameter_that_its_prior_does_not_hold_likely(study_of, value, at_bound, is_far):
    base = (FreeParameter("m", 100.0, 50.0, 200.0, spread=15.0), FreeParameter("k", 1.0))
    study = study_of(np.zeros((1, 1)), [], base=base)
    fitted = Fit("x", {"m": value, "k": 9.0}, {}, np.zeros((1, 1)), 0.0, 0, at_bound)

    assert is_biased(study, fitted) is is_far


def test_several_names_in_one_slot_give_way_only_to_a_law_that_is_better(rivals):
    """Coulomb friction and an offset are two names of one slot; a law that is as good is no better answer."""
    two = ("quadratic_damping", "stribeck")

    assert rivals(SPRING, 0.85 * SPRING, SPRING, SPRING, two).alone_wins
    assert not rivals(SPRING, SPRING, SPRING, SPRING, two).alone_wins
    assert not rivals(SPRING, 0.85 * SPRING, SPRING, SPRING).alone_wins

"""A static law stands for the replay: what is accepted, who is a rival, which effect is needless."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from master.diagnosis.numerics.gains import gain, gain_over, is_accepted, is_worse
from master.diagnosis.numerics.least_squares import Fit
from master.diagnosis.replay.placed_effect import PlacedEffect
from master.diagnosis.search import rounds
from master.diagnosis.search.extended_model import ExtendedModel
from master.diagnosis.search.families import Ranked, family, is_beaten
from master.diagnosis.search.rounds import Round, _is_enough, _most_of_the_rest, shortlist
from master.diagnosis.search.screening import Screened
from master.diagnosis.search.study import Study

N, BLOCKS = 1200, [slice(100 * i, 100 * (i + 1)) for i in range(12)]
T = np.linspace(0.0, 6.0, N)


def fitted(predicted):
    return Fit("x", {}, {}, predicted[:, None], 0.0, 0, ())


def gains(values, spread=0.01, seed=1):
    own = np.exp(-np.asarray(values) + spread * np.random.default_rng(seed).standard_normal(12))
    return gain(fitted(np.zeros(N)), np.ones(12), own)


def ranked(mean, n_parameters, predicted, effect="coulomb"):
    found = gain(fitted(predicted), np.ones(12), np.full(12, np.exp(-mean)))
    effects = (PlacedEffect("sensor", "output", effect),)
    return Ranked(ExtendedModel(effects, parameters=(None,) * n_parameters), found)


@pytest.fixture
def study(study_of):
    """What is measured is zero: a prediction is its own error."""
    return study_of(np.zeros((N, 1)), BLOCKS)


def test_clear_gain_is_accepted_and_a_lucky_one_of_many_is_not():
    assert is_accepted(gains(0.2), 22)
    assert not is_accepted(gains(0.02, spread=0.03), 22)
    assert not is_accepted(gains(0.005, spread=1e-4), 22)


def test_gain_in_few_blocks_counts_against_what_chance_makes():
    """An effect of three times the noise in one block of twelve, and noise that was fitted."""
    rng = np.random.default_rng(3)
    noise = rng.standard_normal(N)
    effect = np.where(T > 5.5, 3.0 * np.sin(9.0 * T), 0.0)
    measured = (effect + noise)[:, None]

    base = fitted(np.zeros(N))
    true, lucky = (
        gain_over(base, fitted(p), measured, BLOCKS, np.ones(1))
        for p in (effect, 0.1 * rng.standard_normal(N))
    )

    assert is_accepted(true, 22)
    assert abs(true.mean / true.error) < 1.5  # blocks without the effect make the mean uncertain
    assert not is_accepted(lucky, 1)


def test_less_by_a_hair_is_not_worse():
    assert is_worse(gains(0.1), gains(0.2))
    assert not is_worse(gains(0.195), gains(0.2))


def test_what_happens_in_few_blocks_decides_too(study):
    """Both leave noise; one misses three times the noise in two blocks of twelve, the other nothing."""
    rng = np.random.default_rng(5)
    noise = rng.standard_normal(N)
    missed = np.where(T > 5.0, 3.0 * np.sin(9.0 * T), 0.0)
    base = fitted(10.0 * rng.standard_normal(N))
    best, poor = (study.gain(base, fitted(left)) for left in (noise, noise + missed))
    as_good = study.gain(base, fitted(noise + 0.1 * rng.standard_normal(N)))

    assert not is_worse(poor, best)
    assert is_beaten(study, poor, best)
    assert not is_beaten(study, best, poor)
    assert not is_beaten(study, as_good, best)


def test_search_ends_where_next_to_nothing_is_left(study):
    assert _is_enough(study, fitted(20.0 * np.sin(T)), fitted(np.cos(T)))
    assert not _is_enough(study, fitted(10.0 * np.sin(T)), fitted(np.cos(T)))


def test_more_parameters_with_the_same_prediction_are_no_rival(study):
    simple, contained = ranked(0.5, 1, np.sin(T)), ranked(0.502, 3, 1.05 * np.sin(T))

    assert family(study, fitted(np.zeros(N)), [contained, simple]) == [simple]


def test_another_prediction_is_a_rival(study):
    one, other = ranked(0.5, 1, np.sin(T)), ranked(0.495, 1, np.cos(T))

    assert family(study, fitted(np.zeros(N)), [one, other]) == [one, other]


def test_worse_one_is_no_rival(study):
    one, other = ranked(0.5, 2, np.sin(T)), ranked(0.4, 1, np.cos(T))

    assert family(study, fitted(np.zeros(N)), [one, other]) == [one]


def test_lag_and_delay_stay_a_family_while_both_explain_most(study):
    delay, lag, poor = (
        ranked(mean, 1, f(T), effect)
        for mean, f, effect in (
            (3.0, np.sin, "extra_delay"),
            (2.0, np.cos, "extra_lag"),
            (0.5, np.tan, "end_effector_inertia"),
        )
    )

    assert family(study, fitted(np.zeros(N)), [delay, lag, poor]) == [delay, lag]


def test_lag_like_one_with_more_parameters_stays_in_the_family(study):
    """A mount resonance predicts what a delay predicts; a ripple with as many parameters is no rival."""
    delay, mount, ripple = (
        ranked(mean, n, size * np.sin(T), effect)
        for mean, n, size, effect in (
            (0.50, 1, 1.0, "extra_delay"),
            (0.51, 3, 1.01, "mount_resonance"),
            (0.50, 3, 1.01, "ripple"),
        )
    )

    assert family(study, fitted(np.zeros(N)), [mount, delay, ripple]) == [mount, delay]


def test_behind_nearly_everything_only_what_explains_most_of_the_rest_counts():
    much, little = (
        Round(None, (), (Ranked(ExtendedModel(), replace(gains(0.5), share=share)),)) for share in (0.6, 0.4)
    )

    assert _most_of_the_rest(much).family == much.family
    assert _most_of_the_rest(little).family == ()


def promising(gain, effect, slot="rope"):
    return Screened(ExtendedModel((PlacedEffect("sensor", slot, effect),)), ({},), gain, {})


def test_an_offset_competes_however_many_others_promise_more():
    """Eight ripples fill the list; an offset of 2 % is fitted with them, one that promises nothing is not."""
    ripples = [promising(0.9 - 0.01 * i, "ripple", f"slot_{i}") for i in range(8)]
    offset = promising(0.02, "offset")
    nothing = promising(1e-4, "offset", "elsewhere")

    fitted_ones = shortlist([*ripples, offset, nothing])

    assert fitted_ones == [*ripples[:6], offset]


@pytest.mark.parametrize("leaves_noise", [True, False])
def test_no_next_effect_decides_in_a_family_that_leaves_noise_alone(study, monkeypatch, leaves_noise):
    base = fitted(np.sin(9.0 * T))
    noise = 0.1 * np.random.default_rng(6).standard_normal(N)
    family_of_two = tuple(
        Ranked(ExtendedModel((PlacedEffect("sensor", "output", name),)), study.gain(base, fitted(noise)))
        for name in ("coulomb", "dahl")
    )
    step = Round(base, family_of_two, family_of_two)
    looked = []

    def looked_ahead(study, base, step, candidates):
        looked.append(step)
        return rounds._Decided(replace(step, family=step.family[:1]), Round(base, (), ()))

    monkeypatch.setattr(rounds, "_step", lambda *_, **__: step)
    monkeypatch.setattr(rounds, "_looked_ahead", looked_ahead)
    monkeypatch.setattr(rounds, "ENOUGH", 0.0)
    monkeypatch.setattr(Study, "fitted", lambda *_: fitted(noise))

    found = rounds.search(study, base, [], at_most=2, is_noise=lambda _: leaves_noise)

    assert len(found.rounds[0].family) == (2 if leaves_noise else 1)
    assert bool(looked) is not leaves_noise
    assert found.model.effects == family_of_two[0].model.effects

"""Regressors without physics: each finds its kind on rows it has not seen, and nothing in noise."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.signal import lfilter

from master.diagnosis.numerics.folds import N_GROUPS, Folds, share_of
from master.diagnosis.numerics.regressors import line, line_over, ridge, trees, without_mains

N = 8000
T = np.arange(N) * 1e-3
RNG = np.random.default_rng(3)
NOISE = RNG.normal(0.0, 1.0, N)
X = np.sin(2.0 * np.pi * 0.83 * T) + 0.4 * np.sin(2.0 * np.pi * 2.71 * T)
FOLDS = Folds.of(np.ones(N, dtype=bool), 100)
COLUMNS = np.column_stack([X, np.gradient(X, T), np.roll(X, 20), RNG.normal(size=N)])


def share(residual, held):
    return share_of(residual, held.explained, FOLDS.block)


def test_every_row_is_held_out_once_and_never_near_what_is_fitted():
    held = np.concatenate([fold.held_out for fold in FOLDS])

    assert np.array_equal(np.sort(held), np.arange(N))
    for fold in FOLDS:
        apart = np.abs(fold.fitted[:, None] - fold.held_out[None, ::50]).min()
        assert apart >= 99
        assert not set(fold.inner_held_out) & set(fold.inner_fitted)
    assert len(list(FOLDS)) == N_GROUPS


def test_nothing_is_predicted_of_noise():
    found = [
        share(NOISE, ridge(NOISE, COLUMNS, FOLDS)),
        share(NOISE, line(NOISE, np.ones(N), T, FOLDS, highest=60.0)),
        share(NOISE, line(NOISE, X, T, FOLDS, highest=60.0)),
        share(NOISE, line_over(NOISE, X, FOLDS)),
    ]

    assert all(abs(s.value) < 0.02 for s in found)
    assert all(s.interval.high < 0.05 for s in found)
    assert share(NOISE, trees(NOISE, COLUMNS, FOLDS)).value < 0.02


def test_a_share_is_the_power_that_is_predicted():
    residual = np.sqrt(3.0) * X / X.std() + NOISE / NOISE.std()

    found = share(residual, ridge(residual, COLUMNS, FOLDS))

    assert found.value == pytest.approx(0.75, abs=0.03)
    assert found.interval.low < found.value < found.interval.high


def test_trees_find_a_threshold_that_no_line_shows():
    residual = 2.0 * (np.abs(X) > 0.8) + 0.5 * NOISE

    assert share(residual, trees(residual, COLUMNS, FOLDS)).value > 0.6


def test_a_stiffness_that_swings_is_a_line_of_the_residual_times_the_position():
    residual = 3.0 * np.sin(2.0 * np.pi * 1.8 * T + 0.4) * X + NOISE

    held = line(residual, X, T, FOLDS, highest=60.0)

    assert held.frequency == pytest.approx(1.8, abs=0.01)
    assert share(residual, held).value > 0.6


def test_hum_of_the_mains_is_no_line_that_predicts():
    residual = np.sin(2.0 * np.pi * 50.0 * T) + 0.1 * NOISE

    assert share(residual, line(residual, np.ones(N), T, FOLDS, highest=200.0)).value < 0.02


def test_hum_that_is_left_in_passes_for_a_law_that_swings():
    hum = 2.0 * np.sin(2.0 * np.pi * 49.97 * T + 0.4)

    assert share(NOISE + hum, line(NOISE + hum, X, T, FOLDS, highest=61.0)).value > 0.15


def test_lines_that_differ_with_what_they_are_found_on_are_no_law():
    """The factor swings at 1.2 Hz in one half of the time and at 3.1 Hz in the other."""
    frequency = np.where(np.arange(N) < N // 2, 1.2, 3.1)
    residual = X * np.sin(2.0 * np.pi * frequency * T)
    halves = Folds.of(np.ones(N, dtype=bool), 100, 4)

    assert share(residual, line(residual, X, T, halves, highest=60.0)).value == 0.0


def test_a_swing_that_ends_is_no_law_that_swings():
    """It is there in three quarters of the time: what it says of the fourth is wrong."""
    long = Folds.of(np.ones(N, dtype=bool), 100, 4)
    swing = X * np.sin(2.0 * np.pi * 1.8 * T)
    ending = np.where(np.arange(N) < 3 * N // 4, swing, 0.0)

    assert share(swing, line(swing, X, T, long, highest=60.0)).value > 0.9
    assert share(ending, line(ending, X, T, long, highest=60.0)).value == 0.0


def test_a_wave_that_wanders_is_hardly_ever_a_law_that_swings():
    """
    Noise of 1.1 Hz that forgets its phase in 2 s, of 8 s: 12 draws.

    Between blocks of half a second its phase can be guessed from both sides, at a frequency of their own: 7
    of the 12 would be predictable.
    """
    pole = 0.9995 * np.exp(2j * np.pi * 1.1e-3)
    long = Folds.of(np.ones(N, dtype=bool), 100, 4)
    shares = []
    for seed in range(12):
        white = np.random.default_rng(seed).standard_normal(N)
        wave = lfilter([1.0], [1.0, -2.0 * pole.real, abs(pole) ** 2], white)
        shares.append(share(wave, line(wave, X, T, long, highest=60.0)).value)

    assert np.sum(np.array(shares) > 0.05) <= 3


@pytest.mark.parametrize("mains", [49.97, 60.02])
def test_hum_of_the_mains_is_no_law_that_swings_and_a_law_that_does_stays_one(mains):
    """X has a line at 0.83 Hz: times one that far from the mains it makes one at the mains."""
    hum = 2.0 * np.sin(2.0 * np.pi * mains * T + 0.4)
    swing = X * np.sin(2.0 * np.pi * 1.8 * T)

    def explained(residual):
        quiet = without_mains(residual, T, FOLDS.rows, highest=61.0)
        return share(residual, line(quiet, X, T, FOLDS, highest=61.0)).value

    assert explained(NOISE + hum) < 0.02
    own = share(NOISE + swing, line(NOISE + swing, X, T, FOLDS, highest=61.0)).value
    assert explained(NOISE + swing + hum) == pytest.approx(
        own / (1.0 + np.var(hum) / np.var(NOISE + swing)), rel=0.1
    )


def test_a_fine_ripple_is_a_line_over_the_position():
    residual = 2.0 * np.sin(2.0 * np.pi * X / 0.011) + NOISE

    held = line_over(residual, X, FOLDS)

    assert 1.0 / held.frequency == pytest.approx(0.011, rel=1e-3)
    assert share(residual, held).value > 0.6

"""Noise of any colour is even in time; what a law leaves at some times more than at others is not."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.signal import lfilter

from master.diagnosis.numerics.evenness import chance_of_unevenness

N = 9000
ROWS = (np.arange(N) % 700) > 150


def coloured(kind, rng):
    white = rng.standard_normal(N)
    if kind == "white":
        return white
    if kind == "lag":
        return lfilter([1.0], [1.0, -0.9], white)
    spectrum = np.fft.rfft(white)
    spectrum[1:] /= np.sqrt(np.arange(1, len(spectrum)))
    spectrum[0] = 0.0
    return np.fft.irfft(spectrum, N) + 0.01 * rng.standard_normal(N)


@pytest.mark.parametrize("kind", ["white", "lag", "pink"])
def test_chance_is_right_for_noise_of_any_colour(kind):
    """Of 150 draws 1.5 are expected below 1 %; more than 8 have a probability of 3e-5 (binomial)."""
    rng = np.random.default_rng(5)
    found = np.array([chance_of_unevenness(coloured(kind, rng), ROWS) for _ in range(150)])

    assert np.sum(found < 0.01) <= 8
    assert np.median(found) > 0.2


def test_a_tone_that_is_there_at_some_times_alone_is_uneven():
    """As much as the noise, at 7 Hz for a row of 1 ms, in half of the time."""
    rng = np.random.default_rng(6)
    noise = rng.standard_normal(N)
    t = 1e-3 * np.arange(N)
    tone = np.sqrt(2.0) * np.sin(2.0 * np.pi * 7.0 * t)

    assert chance_of_unevenness(noise + np.where(t < 4.5, tone, 0.0), ROWS) < 1e-6
    assert chance_of_unevenness(noise + tone, ROWS) > 1e-3


def test_single_rows_that_a_logger_spoilt_do_not_count():
    rng = np.random.default_rng(7)
    noise = rng.standard_normal(N)
    noise[rng.integers(0, 3000, 30)] += 20.0

    assert chance_of_unevenness(noise, ROWS) > 1e-3


def test_too_few_rows_say_nothing():
    assert chance_of_unevenness(np.ones(40), np.ones(40, dtype=bool)) == 1.0
    assert chance_of_unevenness(np.zeros(N), ROWS) == 1.0

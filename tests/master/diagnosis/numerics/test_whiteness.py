from __future__ import annotations

import numpy as np
import pytest
from scipy.signal import lfilter

from master.diagnosis.numerics.whiteness import (
    block_bootstrap,
    correlation_length,
    cross_correlations,
    filtered,
    holm,
    ljung_box,
    whitening,
)

N = 5000


def coloured(rng, n=N, a=0.9):
    return lfilter([np.sqrt(1.0 - a * a)], [1.0, -a], rng.standard_normal(n))


def motion(rng, n=N):
    return lfilter([0.02], [1.0, -1.95, 0.96], rng.standard_normal(n))


def bases(x, v):
    return {
        "x^2": x**2,
        "x^3": x**3,
        "abs x": np.abs(x),
        "v abs v": v * np.abs(v),
        "sign v": np.tanh(v / 0.1),
    }


def test_whitening_finds_the_filter_of_the_noise():
    a = whitening(coloured(np.random.default_rng(1)), order=2)

    assert a == pytest.approx([1.0, -0.9, 0.0], abs=0.04)


def test_whitened_noise_is_white_and_coloured_noise_is_not():
    noise = coloured(np.random.default_rng(2))

    assert ljung_box(noise) < 1e-6
    assert ljung_box(filtered(noise, whitening(noise))) > 0.01


def test_holm_by_hand():
    p = np.array([0.01, 0.04, 0.03])

    assert holm(p) == pytest.approx([0.03, 0.06, 0.06])


@pytest.mark.parametrize("colour", [0.0, 0.9])
def test_nothing_is_found_in_noise(colour):
    false = 0
    for seed in range(100):
        rng = np.random.default_rng(seed)
        x = motion(rng)
        residual = coloured(rng, a=colour)
        found = cross_correlations(residual, bases(x, np.gradient(x)), linear={"x": x})
        false += any(c.is_found for c in found)

    assert false <= 4


@pytest.mark.parametrize("colour", [0.0, 0.9])
@pytest.mark.parametrize("missing", ["x^3", "sign v"])
def test_missing_law_is_found(colour, missing):
    for seed in range(5):
        rng = np.random.default_rng(seed)
        x = motion(rng)
        v = np.gradient(x)
        law = bases(x, v)[missing]
        residual = coloured(rng, a=colour) + law / law.std()

        assert cross_correlations(residual, bases(x, v), linear={"x": x, "v": v})[0].is_found


def test_lag_of_the_strongest_correlation_is_found():
    rng = np.random.default_rng(3)
    x = rng.standard_normal(N)
    residual = np.roll(x**2, 7) + rng.standard_normal(N)

    assert cross_correlations(residual, {"x^2": x**2})[0].lag == 7


def test_bootstrap_covers_the_spread_of_a_mean_of_coloured_noise():
    noise = coloured(np.random.default_rng(4))
    low, high = block_bootstrap(lambda e: float(e.mean()), noise, block=200, seed=1)

    deviation = np.sqrt(19.0 / N)  # (1 + a) / (1 - a) / n for a = 0.9
    assert (high - low) / (2.0 * 1.96) == pytest.approx(deviation, rel=0.3)
    assert low < 0.0 < high


def test_correlation_length_grows_with_the_colour():
    rng = np.random.default_rng(5)

    assert correlation_length(rng.standard_normal(N)) == 10
    assert 70 < correlation_length(coloured(rng)) < 150

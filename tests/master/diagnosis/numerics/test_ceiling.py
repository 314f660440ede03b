from __future__ import annotations

import numpy as np
import pytest
from scipy.signal import lfilter

from master.diagnosis.numerics.ceiling import ceiling, history

N = 5000
BLOCKS = [slice(1000 * i, 1000 * (i + 1)) for i in range(5)]


@pytest.fixture(scope="module")
def x():
    x = lfilter([0.02], [1.0, -1.95, 0.96], np.random.default_rng(1).standard_normal(N))
    return x / x.std()


@pytest.mark.parametrize("colour", [0.0, 0.9])
def test_noise_has_no_ceiling(x, colour):
    features = history({"x": x, "v": np.gradient(x)}, [])
    found = 0
    for seed in range(5):
        white = np.random.default_rng(100 + seed).standard_normal(N)
        found += ceiling(lfilter([1.0], [1.0, -colour], white), features, BLOCKS).is_structure

    assert found == 0


@pytest.mark.parametrize(
    "law", [lambda x, v: x**3, lambda x, v: np.tanh(5.0 * v), lambda x, v: np.maximum(x, 0.0) ** 1.5]
)
def test_share_of_a_law_under_noise_is_found(x, law):
    v = np.gradient(x) * 10.0
    effect = law(x, v)
    effect = (effect - effect.mean()) / effect.std()
    residual = effect + np.random.default_rng(2).standard_normal(N)

    found = ceiling(residual, history({"x": x, "v": v}, []), BLOCKS)
    assert found.share == pytest.approx(0.5, abs=0.1)
    assert found.is_structure
    assert np.corrcoef(found.explained, effect)[0, 1] > 0.9


def test_law_with_memory_needs_the_history(x):
    lagged = lfilter([0.02], [1.0, -0.98], x)
    residual = (
        np.tanh(2.0 * (x - lagged))
        - np.tanh(2.0 * x) * 0.5
        + 0.1 * np.random.default_rng(3).standard_normal(N)
    )

    without, with_it = (
        ceiling(residual, history({"x": x}, lags), BLOCKS).share for lags in ([], [20, 60, 120])
    )
    assert with_it > without + 0.1


def test_history_repeats_the_start():
    found = history({"x": np.array([1.0, 2.0, 3.0, 4.0])}, [2])

    assert found.shape == (4, 2)
    assert found[0, 1] == found[1, 1] == found[2, 1] < found[3, 1]

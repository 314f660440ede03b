"""The gain on the sealed rows: its number by hand, and when it is within chance."""

from __future__ import annotations

import numpy as np
import pytest

from master.diagnosis.numerics.sealed_gain import sealed_gain

N = 3000
NOISE = np.random.default_rng(4).normal(0.0, 1.0, (N, 1))
ONE = np.ones(1)


def test_half_the_amplitude_is_three_quarters_of_the_power():
    gain = sealed_gain(np.zeros((N, 1)), 2.0 * NOISE, NOISE, ONE)

    assert gain.value == pytest.approx(0.75)
    assert gain.interval == pytest.approx((0.75, 0.75))


def test_another_noise_is_no_gain():
    other = np.random.default_rng(5).normal(0.0, 1.0, (N, 1))

    gain = sealed_gain(np.zeros((N, 1)), NOISE, other, ONE)

    assert gain.interval.low < 0.0 < gain.interval.high


def test_a_replay_that_ended_early_has_no_gain():
    broken = NOISE.copy()
    broken[-1] = np.nan

    assert sealed_gain(np.zeros((N, 1)), NOISE, broken, ONE) is None

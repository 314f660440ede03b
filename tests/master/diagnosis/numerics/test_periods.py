from __future__ import annotations

import numpy as np
import pytest

from master.diagnosis.numerics.periods import likely_frequencies, likely_periods, waves

T = np.arange(5000) * 1e-3
POSITION = 1e-3 * (np.sin(3.0 * T) + 0.5 * np.sin(7.3 * T))


def gain_of(left):
    """Share of a residual's power (n,) that functions explain if the model hands them on as they are."""

    def gain(functions):
        rest = left - functions @ np.linalg.lstsq(functions, left, rcond=None)[0]
        return 1.0 - float(rest @ rest) / float(left @ left)

    return gain


@pytest.mark.parametrize("period", [0.06e-3, 0.3e-3, 1.1e-3])
def test_period_is_found_under_noise_to_half_a_cycle_along_the_way(period):
    left = waves(POSITION, period) @ [1.0, 0.4] + np.random.default_rng(1).standard_normal(len(T))

    found = likely_periods(POSITION, gain_of(left), 3)
    assert len(found) == 3
    assert abs(np.ptp(POSITION) / found[0] - np.ptp(POSITION) / period) <= 0.5


def test_standstill_has_no_period():
    assert likely_periods(np.full(100, 3.0), gain_of(T[:100]), 3) == []


@pytest.mark.parametrize("frequency", [0.6, 1.8, 7.3])
def test_frequency_at_which_a_position_is_modulated_is_found_under_noise(frequency):
    left = POSITION[:, None] * waves(T, 1.0 / frequency) @ [1.0, 0.4]
    left = left + 0.5e-3 * np.random.default_rng(1).standard_normal(len(T))

    found = likely_frequencies(T, POSITION, gain_of(left), 3)
    assert len(found) == 3
    assert abs(found[0] - frequency) * np.ptp(T) <= 0.5


def test_what_is_not_there_or_too_short_has_no_frequency():
    assert likely_frequencies(T, 0.0 * T, gain_of(T), 3) == []
    assert likely_frequencies(T[:100], POSITION[:100], gain_of(T[:100]), 3) == []

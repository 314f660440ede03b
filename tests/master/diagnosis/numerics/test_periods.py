from __future__ import annotations

import numpy as np
import pytest

from master.diagnosis.numerics.periods import likely_periods, waves

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

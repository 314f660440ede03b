from __future__ import annotations

import numpy as np
import pytest

from master.diagnosis.numerics.quanta import likely_steps, rounding

T = np.arange(10_000) * 1e-3
VALUE = 200.0 * np.sin(3.0 * T) + 100.0 * np.sin(7.3 * T)


@pytest.mark.parametrize("step", [0.8, 1.0, 2.0, 2.9])
def test_step_is_found_under_noise(step):
    left = rounding(VALUE, step) + 0.5 * np.random.default_rng(1).standard_normal(len(T))

    assert likely_steps(VALUE, left)[0] == pytest.approx(step, rel=1e-4)


def test_step_of_a_small_value_without_noise():
    value = 1e-5 * VALUE

    assert likely_steps(value, rounding(value, 2e-4))[0] == pytest.approx(2e-4, rel=1e-3)


def test_value_within_one_step_has_none():
    assert likely_steps(np.full(100, 3.0), np.random.default_rng(1).standard_normal(100)) == []


def test_rounding_is_less_than_half_a_step():
    assert np.abs(rounding(VALUE, 2.0)).max() <= 1.0

from __future__ import annotations

import numpy as np
import pytest

from master.diagnosis.numerics.drift import drift

AMPLITUDE = np.array([1.0, 2.0, 3.0, 4.0, 5.0])
TIME = np.array([0.0, 1.0, 0.0, 1.0, 0.0])
ERRORS = np.full(5, 0.1)


def test_parameter_that_grows_with_amplitude_is_an_effect():
    found = drift("k", 10.0 + 0.5 * AMPLITUDE, ERRORS, {"amplitude": AMPLITUDE, "time": TIME})

    assert not found.is_constant
    assert found.along == "amplitude"
    assert found.slope == pytest.approx(0.5)
    assert found.slope_deviation == pytest.approx(0.1 / np.sqrt(10.0))


def test_parameter_that_scatters_within_its_uncertainty_is_a_number():
    constant = 0
    for seed in range(200):
        values = 10.0 + ERRORS * np.random.default_rng(seed).standard_normal(5)
        constant += drift("k", values, ERRORS, {"amplitude": AMPLITUDE}).is_constant

    assert constant >= 195

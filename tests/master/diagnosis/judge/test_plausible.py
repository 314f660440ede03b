"""Size of a signal against the model's: what a wrong unit or sign makes of it."""

from __future__ import annotations

import numpy as np
import pytest

from master.diagnosis.numerics.likeness import size_against, slope_of_small

MODEL = np.sin(np.arange(500) / 20.0) + 2.0
NOISE = np.random.default_rng(1).standard_normal(500)


@pytest.mark.parametrize("factor", [1e-3, -1.0, 57.3, 1.0])
def test_ratio_is_the_factor_between_the_units(factor):
    assert size_against(factor * MODEL + 5.0, MODEL) == pytest.approx(factor, rel=1e-9)


@pytest.mark.parametrize("factor", [1e-3, -1.0, 1.0])
def test_slope_where_it_is_small_is_that_factor_too(factor):
    assert slope_of_small(factor * MODEL, MODEL) == pytest.approx(factor, rel=1e-9)


def test_signal_that_is_cut_off_has_the_size_of_the_model_where_it_is_small():
    cut = np.clip(MODEL - MODEL.mean(), -0.2, 0.2)

    assert size_against(cut, MODEL) < 0.3
    assert slope_of_small(cut, MODEL) == pytest.approx(1.0, abs=0.1)


def test_signals_that_are_not_alike_have_none():
    assert size_against(1e3 * NOISE, MODEL) == 1.0
    assert size_against(NOISE, np.zeros(500)) == 1.0
    assert size_against(NOISE, np.full(500, np.nan)) == 1.0

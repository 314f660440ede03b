"""Splines of a slot's signals: they sum to one, also where a signal rests or jumps."""

from __future__ import annotations

import numpy as np
import pytest

from master.diagnosis.adequacy.slot_laws import splines

SINE = np.sin(np.linspace(0.0, 30.0, 2000))


@pytest.mark.parametrize(
    "values",
    [
        SINE,
        1e-6 * SINE,
        np.concatenate([np.zeros(3000), SINE]),
        np.sign(SINE),
        np.where(np.arange(2000) == 700, 5.0, 0.0),
    ],
)
def test_splines_sum_to_one_wherever_the_signal_is(values):
    columns = splines(values, 14)

    assert columns.shape == (len(values), 14)
    assert columns.sum(axis=1) == pytest.approx(np.ones(len(values)))
    assert columns.min() >= 0.0

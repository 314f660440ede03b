"""What strikes a lightly damped oscillator is found, though its power is everywhere; steady noise is not."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.signal import lfilter

from master.diagnosis.numerics.strikes import events, strikes

N = 8000  # rows of 1 ms
ALL = np.ones(N, dtype=bool)
WINDOW, EVERY = 50, 10
NOISE = np.random.default_rng(4).standard_normal(N)


def rung(force):
    """Answer of an oscillator of 6.7 Hz and 3 % damping to a force (N,), by its exact poles."""
    pole = np.exp((-0.03 + 1j) * 2.0 * np.pi * 6.7e-3)
    return lfilter([1.0], [1.0, -2.0 * pole.real, abs(pole) ** 2], force)


def struck_at(rows):
    force = np.zeros(N)
    for row in rows:
        force[row : row + 30] = 0.05
    return rung(force) + 0.5 * NOISE


def test_strikes_that_ring_on_are_found_when_they_happen():
    rows = [610, 1370, 2110, 2930, 4410, 5830, 7260]
    left = struck_at(rows)

    found = strikes(left, ALL, WINDOW, EVERY)

    assert len(events(left, ALL, WINDOW)) == 0
    assert all(np.abs(found - row).min() <= WINDOW for row in rows)
    assert all(np.abs(np.array(rows) - row).min() <= 2 * WINDOW for row in found)


@pytest.mark.parametrize(
    "shaken", [NOISE, rung(0.02 * NOISE), np.cumsum(NOISE), np.sin(0.01 * np.arange(N)) + NOISE]
)
@pytest.mark.parametrize("every", [EVERY, 2 * EVERY])
def test_steady_noise_of_any_colour_has_none(shaken, every):
    assert len(strikes(shaken, ALL, WINDOW, every)) == 0
    assert len(events(shaken, ALL, WINDOW)) == 0


def test_rows_that_are_not_in_use_are_not_looked_at():
    rows = ALL.copy()
    rows[2000:4000] = False
    left = struck_at([610, 2930, 5830])
    other = np.where(rows, left, 1e6)

    found = strikes(other, rows, WINDOW, EVERY)

    assert found.tolist() == strikes(np.where(rows, left, 0.0), rows, WINDOW, EVERY).tolist()
    assert len(found) > 0
    assert not np.any((found >= 2000) & (found < 4000))


def test_power_in_few_windows_is_an_event_without_any_model():
    left = 0.1 * NOISE
    left[3000:3050] += 5.0

    assert events(left, ALL, WINDOW).tolist() == [3000]

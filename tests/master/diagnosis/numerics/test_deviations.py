"""Deviations hold: 95 % intervals contain the true value in about 95 % of draws, in coloured noise too."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.signal import lfilter

from master.diagnosis.numerics.deviations import sandwich

N = 4000
T = np.arange(N) * 1e-3
J = np.column_stack([np.sin(2.0 * np.pi * 0.4 * T), np.ones(N)])


def covered(noise):
    """Share of draws whose interval holds the truth, for both unknowns."""
    hits = np.zeros(2)
    for e in noise:
        x = np.linalg.lstsq(J, e, rcond=None)[0]
        deviation = np.sqrt(np.diag(sandwich(J, e - J @ x, 1, 0)))
        hits += np.abs(x) < 1.96 * deviation
    return hits / len(noise)


@pytest.mark.parametrize("pole", [0.0, 0.9, 0.98])
def test_intervals_hold_the_truth_whatever_the_colour(pole):
    white = np.random.default_rng(7).standard_normal((300, N + 500))
    noise = lfilter([1.0], [1.0, -pole], white)[:, 500:]

    assert np.all(covered(noise) >= 0.88)
    assert np.all(covered(noise) <= 0.99)


def test_a_prior_counts_as_what_it_says():
    """2400 rows of white noise of deviation 1 and a prior that knows as much: 1/sqrt(2 * 2400)."""
    n = 2400
    jacobian = np.vstack([np.ones((n, 1)), [[np.sqrt(n)]]])
    draws = np.random.default_rng(8).standard_normal((40, n))
    residuals = [np.concatenate([noise - noise.mean(), [0.0]]) for noise in draws]

    deviation = float(np.mean([np.sqrt(sandwich(jacobian, r, 1, 1)[0, 0]) for r in residuals]))

    assert deviation == pytest.approx(1.0 / np.sqrt(2.0 * n), rel=0.1)


def test_what_no_row_depends_on_alone_or_in_a_sum_is_not_known_at_all():
    """Of two equal columns the sum is known, and neither of them; the others keep their deviation."""
    noise = np.random.default_rng(9).standard_normal(N)
    jacobian = np.column_stack([J, np.zeros(N), 2.0 * T, T])
    alone = np.sqrt(np.diag(sandwich(np.column_stack([J, T]), noise, 1, 0)))

    deviation = np.sqrt(np.diag(sandwich(jacobian, noise, 1, 0)))

    assert np.isinf(deviation).tolist() == [False, False, True, True, True]
    assert deviation[:2] == pytest.approx(alone[:2], rel=1e-2)

"""What of the difference of two runs is an answer, and what is rounding."""

from __future__ import annotations

import numpy as np

from master.analysis.identify.responses import answer_of

DELTA = 1e-4


def pulse_of(gain, size_at_rest):
    """Runs of 50 steps with two outputs: the motion at rest with a pulse's answer on it, and rounding."""
    rng = np.random.default_rng(2)
    decay = 0.9 ** np.arange(50.0)

    def pulse(place, delta):
        rounding = size_at_rest * np.finfo(float).eps * rng.standard_normal((50, 2))
        return size_at_rest + rounding + delta * decay[:, None] * np.array([gain, 0.0])

    return pulse


def test_what_differs_by_rounding_only_is_no_answer():
    """An input that cancels inside an FMU: else its rounding, scaled up to 1, spoils the realisation."""
    answer, bent = answer_of(pulse_of(0.0, 150.0), 0, DELTA)

    assert (answer == 0.0).all()
    assert bent == 0.0


def test_a_small_answer_on_a_large_motion_is_one():
    answer, _ = answer_of(pulse_of(0.5, 150.0), 0, DELTA)

    np.testing.assert_allclose(answer[:, 0], 0.5 * 0.9 ** np.arange(50.0), atol=1e-8)
    assert (answer[:, 1] == 0.0).all()

from __future__ import annotations

import math

import pytest

from fmu_sources.effects.framework.shapes import clip, dead_zone, larger, smooth_sign
from fmu_sources.framework.arithmetic import PYTHON as M


@pytest.mark.parametrize(
    ("value", "clipped", "beyond"), [(-3.0, -2.0, -1.0), (0.5, 0.5, 0.0), (2.5, 2.0, 0.5)]
)
def test_a_value_is_kept_between_limits_and_the_rest_is_what_is_beyond(value, clipped, beyond):
    assert clip(value, -2.0, 2.0, M) == clipped
    assert dead_zone(value, 2.0, M) == beyond


def test_a_sign_is_rounded_over_its_smoothing():
    assert smooth_sign(0.0, 0.1, M) == 0.0
    assert smooth_sign(0.1, 0.1, M) == math.tanh(1.0)
    assert smooth_sign(-10.0, 0.1, M) == -1.0


@pytest.mark.parametrize(("a", "b", "most"), [(1.0, 2.0, 2.0), (2.0, 1.0, 2.0), (-1.0, -1.0, -1.0)])
def test_the_larger_of_two(a, b, most):
    assert larger(a, b, M) == most

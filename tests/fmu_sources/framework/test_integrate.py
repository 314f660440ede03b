from __future__ import annotations

import math

import pytest

from fmu_sources.framework.integrate import n_substeps, runge_kutta_4


@pytest.mark.parametrize(
    ("step", "longest", "n"),
    [(1e-3, 1e-3, 1), (1e-3, 0.2e-3, 5), (1.01e-3, 0.2e-3, 6), (1e-4, 0.2e-3, 1), (3 * 0.1, 0.1, 3)],
)
def test_substeps_are_none_longer_than_the_longest(step, longest, n):
    assert n_substeps(step, longest) == n


def test_a_cubic_in_time_is_integrated_exactly():
    h = 0.25
    found = runge_kutta_4(lambda place, x: [h * (place * h) ** 3], 8, [1.0])

    assert found == pytest.approx([1.0 + 2.0**4 / 4.0], rel=1e-14)


def test_the_error_falls_with_the_fourth_power_of_the_step():
    """X'' = -x over 1 s, against cos(1)."""

    def error(n):
        h = 1.0 / n
        x = runge_kutta_4(lambda _, x: [h * x[1], -h * x[0]], n, [1.0, 0.0])
        return abs(x[0] - math.cos(1.0))

    assert error(10) / error(20) == pytest.approx(16.0, rel=0.05)

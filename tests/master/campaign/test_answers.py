"""Intervals and sensitivities against exact values."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import stats

from master.campaign.campaign import Design
from master.campaign.design import unit_points
from master.campaign.interval import Running, probability
from master.campaign.page import growing_share
from master.campaign.sensitivity import sobol_indices, tornado

A, B = 7.0, 0.1
V1 = 0.5 * (1 + B * np.pi**4 / 5) ** 2
V2 = A**2 / 8
V13 = B**2 * np.pi**8 * (1 / 18 - 1 / 50)
FIRST = np.array([V1, V2, 0.0]) / (V1 + V2 + V13)
TOTAL = np.array([V1 + V13, V2, V13]) / (V1 + V2 + V13)


def ishigami(x):
    return np.sin(x[:, 0]) + A * np.sin(x[:, 1]) ** 2 + B * x[:, 2] ** 4 * np.sin(x[:, 0])


def test_sobol_indices_of_the_ishigami_function_are_the_exact_ones():
    u = unit_points(Design(method="saltelli", size=8192, seed=1), 3)
    found = sobol_indices(["x1", "x2", "x3"], ishigami(np.pi * (2 * u - 1)))

    assert np.abs([i.first.value for i in found] - FIRST).max() < 0.02
    assert np.abs([i.total.value for i in found] - TOTAL).max() < 0.02
    assert all(i.total.low <= i.total.value <= i.total.high for i in found)


def test_points_without_a_number_are_left_out():
    u = unit_points(Design(method="saltelli", size=4096, seed=1), 3)
    values = ishigami(np.pi * (2 * u - 1))
    values[::97] = np.nan
    found = sobol_indices(["x1", "x2", "x3"], values)

    assert np.abs([i.total.value for i in found] - TOTAL).max() < 0.05


@pytest.mark.parametrize(("hits", "n"), [(0, 50), (3, 80), (50, 50), (400, 1000)])
def test_the_interval_of_a_probability_is_that_of_wilson(hits, n):
    found = probability(hits, n)
    other = stats.binomtest(hits, n).proportion_ci(method="wilson")

    assert (found.low, found.high) == pytest.approx((other.low, other.high), abs=1e-12)


def test_a_running_mean_is_that_of_all_numbers_but_those_that_are_none():
    values = np.random.default_rng(1).normal(5.0, 2.0, 400)
    running = Running(is_share=False)
    for value in [*values, None, np.nan]:
        running.add(value)
    found = running.interval()

    assert (found.value, found.n) == (pytest.approx(values.mean()), 400)
    assert found.half_width == pytest.approx(1.959964 * values.std(ddof=1) / 20.0)


def test_a_tornado_lists_the_largest_change_first():
    rng = np.random.default_rng(1)
    inputs = {"weak": rng.random(5000), "strong": rng.random(5000)}
    found = tornado(inputs, inputs["weak"] - 5.0 * inputs["strong"])

    assert [bar.key for bar in found] == ["strong", "weak"]
    assert found[0].span == pytest.approx(4.0, abs=0.1)  # 5 times the 0.8 between the middles of the fifths


def test_a_run_that_grows_and_ends_below_its_limits_is_not_taken_for_stable():
    columns = {
        "status": np.array(["completed", "completed", "diverged", "completed", "failed", "completed"]),
        "growth_per_cycle": np.array([1.2, 0.9, 3.0, np.nan, np.nan, 1.0]),
    }

    assert growing_share(columns).value == pytest.approx(1 / 3)
    assert growing_share({"status": columns["status"]}) is None

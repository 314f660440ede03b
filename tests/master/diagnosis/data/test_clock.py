"""Clocks that are printed short, have gaps or jitter: expected times by hand."""

from __future__ import annotations

import numpy as np
import pytest

from master.diagnosis.data.clock import ClockRules, clock_of, coarsest_print

N = 4000


def look(t, **rules):
    return clock_of(t, coarsest_print(t), ClockRules(**rules), "run", 2)


@pytest.mark.parametrize("period", [0.0004, 0.00137, 0.0125])
@pytest.mark.parametrize("form", ["%.3f", "%.4g", "%.5g"])
def test_a_clock_printed_short_has_the_period_of_its_ends(period, form):
    true = np.arange(N) * period
    t = np.array([float(form % v) for v in true])
    found = look(t)

    assert not found.problems
    assert found.period == pytest.approx(period, rel=2e-4)
    assert np.abs(found.t - true).max() < 1.1 * max(t[-1] - float(form % (t[-1] - 1e-9)), 0.01)


def test_a_clock_that_is_cut_off_instead_of_rounded_is_printed_short_too():
    true = np.arange(N) * 0.0013
    found = look(np.floor(true * 1e3) / 1e3)

    assert found.period == pytest.approx(0.0013, rel=1e-4)
    assert "4000 times replaced by even ones" in found.notes[0]


def test_single_precision_is_a_short_print():
    true = 5000.0 + np.arange(N) * 0.001
    t = true.astype(np.float32).astype(float)
    found = look(t, start=None)

    assert np.abs(np.diff(t) - 0.001).max() > 2e-4
    assert found.period == pytest.approx(0.001, rel=1e-4)
    assert not found.problems


def test_a_lost_row_is_no_short_print():
    t = np.arange(N) * 0.001
    t[2000:] += 0.001
    found = look(np.round(t, 3))

    assert found.problems == ("run: row 2002: gap, got a step of 0.002 s after t=1.999 s, expected 0.001 s",)


def test_jitter_with_all_its_digits_is_no_short_print():
    t = np.arange(N) * 0.001 + 2e-4 * np.sin(np.arange(N))

    assert any("jitter" in line for line in look(t).problems)


def test_jitter_larger_than_the_print_is_no_short_print():
    t = np.round(np.arange(N) * 0.01 + 0.004 * np.sin(1.7 * np.arange(N)), 3)

    assert any("jitter" in line for line in look(t).problems)


def test_a_short_print_with_a_gap_is_refused_or_cut_there():
    true = np.arange(N) * 0.0013
    true[1000:] += 2.7
    t = np.round(true, 2)
    found = look(t, splits=True)

    assert look(t).problems
    assert found.pieces == ((0, 1000), (1000, N))
    assert found.period == pytest.approx(0.0013, rel=1e-3)
    assert not found.problems
    assert "gaps: 1, the longest of 2.70" in found.notes[1]


def test_gaps_are_cut_where_the_case_says_so_and_jitter_stays_a_fault():
    t = np.arange(N) * 0.001
    t[1000:] += 0.5
    t[1500] += 2e-4
    found = look(t, splits=True)

    assert found.pieces == ((0, 1000), (1000, N))
    assert [line.split(":")[2].split(",")[0] for line in found.problems] == [" jitter", " jitter"]


def test_hints_say_what_a_case_may_write():
    t = np.arange(N) * 0.001
    t[1000:] += 0.5

    assert look(t, hints=True).problems[0].endswith("(time.gaps: split cuts there)")

"""Resampling, counts and two loggers: numbers by hand."""

from __future__ import annotations

import numpy as np
import pytest
import scipy

from master.diagnosis.data.counts import signed, unwrapped
from master.diagnosis.data.merge import Delay, Sought, by_relation, by_shared, merged
from master.diagnosis.data.recordings import Rows, pieces_of
from master.diagnosis.data.resample import Method, resampled
from master.errors import DataError


def test_counts_in_twos_complement_have_a_sign():
    assert signed(np.array([0.0, 32767.0, 32768.0, 65535.0]), 16).tolist() == [0.0, 32767.0, -32768.0, -1.0]


@pytest.mark.parametrize("wrong", [[1.5, 2.0], [65536.0, 1.0], [-40000.0, 1.0], [-1.0, 40000.0]])
def test_counts_that_do_not_fit_are_refused(wrong):
    with pytest.raises(ValueError, match="bits, got"):
        signed(np.array(wrong), 16)


def test_a_counter_is_followed_over_its_ends():
    way = np.cumsum(np.full(1000, 700.0))
    counts = signed(np.mod(way, 65536.0), 16)

    assert np.array_equal(unwrapped(counts, 2.0**16) - counts[0], way - way[0])


def test_a_counter_that_moves_by_half_its_range_is_refused():
    with pytest.raises(ValueError, match="which way it went is not known"):
        unwrapped(np.array([0.0, 32000.0, 0.0]), 2.0**16)


@pytest.mark.parametrize(("method", "error"), [("linear", 2e-4), ("cubic", 1e-6), ("previous", 2e-2)])
def test_rows_with_jitter_become_even(method, error):
    rng = np.random.default_rng(3)
    t = np.arange(2000) * 0.001 + rng.uniform(-4e-4, 4e-4, 2000)
    made = resampled(t, {"q": np.sin(6.0 * t)}, 0.002, Method(method))

    assert np.allclose(np.diff(made.t), 0.002)
    assert made.t[-1] <= t[-1] + 1e-9
    assert np.abs(made.signals["q"] - np.sin(6.0 * made.t)).max() < error
    assert f"resampled ({method}): 2000 rows" in made.note
    assert "is folded" in made.note


def test_the_mean_averages_noise_that_a_longer_period_would_fold():
    rng = np.random.default_rng(4)
    t = np.arange(10_000) * 1e-3
    made = resampled(t, {"e": rng.standard_normal(10_000)}, 0.02, Method.MEAN)

    assert made.signals["e"].std() == pytest.approx(1.0 / np.sqrt(20.0), rel=0.15)
    assert "folded" not in made.note


def test_pieces_between_gaps_that_are_too_short_are_counted_and_left_out():
    t = np.arange(600) * 0.01
    rows = Rows(t, ((0, 250), (250, 300), (300, 600)), 0.01, {"q": t})
    first, second = pieces_of(rows, "run", "run.csv")

    assert (first.name, len(first), second.name, len(second)) == ("run[1]", 250, "run[2]", 300)
    assert first.entry == second.entry == "run"
    assert first.notes == ("left out: 50 rows of pieces with fewer than 100 between gaps",)


def stroke(t):
    """One stroke of 0.1 m in one direction, and its speed."""
    s = np.clip((t - 0.5) / 2.0, 0.0, 1.0)
    return 0.1 * (10 * s**3 - 15 * s**4 + 6 * s**5), 0.05 * (30 * s**2 - 60 * s**3 + 30 * s**4)


def two_loggers(delay, rng):
    first_t = np.arange(3000) * 0.001
    second_t = np.arange(2400) * 0.00127
    q, v = stroke(first_t)
    q_then, v_then = stroke(second_t - delay)
    force = 3000.0 * q_then + 400.0 * v_then + 8.0 * np.tanh(v_then / 1e-4)
    first = Rows(first_t, ((0, 3000),), 0.001, {"q": q + 1e-6 * rng.standard_normal(3000), "v": v})
    noise = 0.3 * rng.standard_normal(2400)
    second = Rows(second_t, ((0, 2400),), 0.00127, {"force": force + noise, "q2": 1e3 * q_then + 4.0})
    return first, second


@pytest.mark.parametrize("delay", [0.004, -0.004, 0.0007])
def test_the_delay_of_two_loggers_is_found_on_one_stroke_by_the_relation(delay):
    first, second = two_loggers(delay, np.random.default_rng(1))
    found = by_relation(
        first,
        second,
        lambda columns, _: columns,
        drivers=["q", "v"],
        rates=["v"],
        compared=["force"],
        open_rows=np.ones(3000, dtype=bool),
        sought=Sought(-0.03, 0.03),
    )

    assert found.value == pytest.approx(delay, abs=5e-4)
    assert 0.0 < found.deviation < 5e-4


def smoothed(columns, period):
    """A position, low-passed at 30 Hz, with its rates."""
    q = scipy.signal.filtfilt(*scipy.signal.butter(4, 30.0, fs=1.0 / period), columns["q"])
    v = np.gradient(q, period)
    return {**columns, "q": q, "v": v, "a": np.gradient(v, period)}


def test_a_delay_that_noise_makes_of_damping_is_refused():
    """Of a cycloid a force that is later is one with more damping: -5.5 +- 0.5 ms was told for 4 ms."""
    rng = np.random.default_rng(21)
    w = np.pi
    first_t = np.arange(2000) * 0.001
    second_t = np.arange(0.0, 1.98, 0.00127)
    q = 0.1 * (first_t / 2.0 - np.sin(w * first_t) / (2.0 * w)) + 2e-7 * rng.standard_normal(2000)
    force = 4.75 * w * np.sin(w * second_t) + 15.0 * (1.0 - np.cos(w * second_t)) + 25.0
    force += 0.3 * rng.standard_normal(len(force))
    first = Rows(first_t, ((0, 2000),), 0.001, {"q": q})
    second = Rows(second_t + 0.004, ((0, len(force)),), 0.00127, {"force": force})

    with pytest.raises(DataError, match="with as much noise again"):
        by_relation(
            first,
            second,
            smoothed,
            drivers=["q", "v", "a"],
            rates=["v"],
            compared=["force"],
            open_rows=np.ones(2000, dtype=bool),
            sought=Sought(-0.02, 0.02),
        )


@pytest.mark.parametrize("delay", [0.004, -0.0113])
def test_the_delay_of_two_loggers_is_found_by_what_both_recorded(delay):
    first, second = two_loggers(delay, np.random.default_rng(2))
    found = by_shared(first, second, {"q": "q2"}, Sought(-0.03, 0.03))

    assert found.value == pytest.approx(delay, abs=1e-4)


def test_a_delay_beyond_its_bounds_is_refused():
    first, second = two_loggers(0.02, np.random.default_rng(2))

    with pytest.raises(DataError, match="got the best at its bound"):
        by_shared(first, second, {"q": "q2"}, Sought(-0.01, 0.01))


def test_no_delay_is_told_where_nothing_moves_together():
    first, second = two_loggers(0.0, np.random.default_rng(2))
    noise = Rows(
        second.t, second.pieces, second.period, {"q2": np.random.default_rng(9).standard_normal(2400)}
    )

    with pytest.raises(DataError, match=r"merge\.delay"):
        by_shared(first, noise, {"q": "q2"}, Sought(-0.01, 0.01))


def test_merged_rows_are_those_that_both_loggers_have():
    first, second = two_loggers(0.004, np.random.default_rng(2))
    gap = Rows(second.t, ((0, 1000), (1100, 2400)), second.period, second.signals)
    found = merged(first, gap, Delay(0.004, 0.0, "given"))
    q, _ = stroke(found.t)

    assert np.abs(found.signals["q2"] - (1e3 * q + 4.0)).max() < 1e-3
    assert len(found.pieces) == 2
    lost = 3000 - len(found.t)
    assert lost == np.sum((first.t + 0.004 > second.t[999]) & (first.t + 0.004 < second.t[1100]))
    assert f"delay 0.004 s (given); {lost} rows without it left out" in found.notes[-1]

"""Adequacy of a channel on a part that is a formula: noise, a law of what drives it, a swing, an event."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest
from scipy.signal import lfilter

from master.diagnosis.adequacy.channels import Judge, Kind
from master.diagnosis.judge.stages import Stage
from master.diagnosis.numerics.noise_floor import Evidence

N = 8000
T = np.arange(N) * 1e-3
U = np.sin(2.0 * np.pi * 0.83 * T) + 0.5 * np.sin(2.0 * np.pi * 2.3 * T + 1.0)
NOISE = 0.1 * np.random.default_rng(5).standard_normal(N)


class Recording(dict):
    def __len__(self):
        return N


def judge_of(residual):
    """Y = 3 u, measured with a residual."""
    measured = (3.0 * U + residual)[:, None]
    recording = Recording(u=U)
    bench = SimpleNamespace(
        part=SimpleNamespace(columns=[SimpleNamespace(signal="u")]),
        recordings={"r": recording},
        raw={"r": measured},
        outputs=["a.y"],
        period=1e-3,
        row_period=1e-3,
        times=T,
        in_use=np.ones(N, dtype=bool),
        measured=measured,
        signal=lambda name: recording[name],
        compared_rows=lambda values: values,
    )
    study = SimpleNamespace(
        bench=bench,
        base=(),
        fit_rows=np.ones(N, dtype=bool),
        held_out=(),
        measured=measured,
        signals={},
        output_scale=np.ones(1),
        replayed_with_noise=lambda values, deviations, n: np.zeros((n, N, 1)),
    )
    return Judge(study, {}, (3.0 * U)[:, None])


def channel(residual):
    [found] = judge_of(residual).judge((3.0 * U)[:, None])
    return found


def test_white_noise_is_adequate():
    found = channel(NOISE)

    assert found.is_adequate
    assert found.floor.evidence is Evidence.DIFFERENCES
    assert found.ratio == pytest.approx(1.0, abs=0.05)
    assert found.share.value < 0.01


def test_white_noise_is_noise_and_coloured_noise_is_more_than_the_differences_show():
    """Both are adequate; differences of neighbours are smaller where noise is coloured."""
    coloured = lfilter([1.0], [1.0, -0.7], NOISE)

    white, red = (Stage("refit", (channel(left),)) for left in (NOISE, coloured))

    assert white.is_noise
    assert red.is_adequate
    assert not red.is_noise


def test_rounding_that_repeats_over_a_signal_is_not_taken_for_noise():
    """A sensor in steps of 0.5: differences take its jumps for noise, and yet a converter is missing."""
    steps = 0.5 * np.round(3.0 * U / 0.5) - 3.0 * U
    coarse = Stage("refit", (channel(steps + 0.3 * NOISE),))

    assert not coarse.channels[0].is_unpredicted
    assert not coarse.is_noise


def test_a_law_of_what_drives_the_part_is_predictable_by_its_share():
    found = channel(NOISE + 0.2 * np.abs(U))

    assert found.is_predictable
    assert not found.is_adequate
    assert found.share.value == pytest.approx(1.0 - 0.01 / np.mean((NOISE + 0.2 * np.abs(U)) ** 2), abs=0.1)


def test_a_gain_that_swings_is_told_with_its_frequency():
    found = channel(NOISE + 0.6 * np.sin(2.0 * np.pi * 1.37 * T) * U)

    assert found.best.kind is Kind.MODULATED
    assert found.best.frequency == pytest.approx(1.37, abs=0.02)
    assert str(found.best) == f"periodic in time at {found.best.frequency:.4g} Hz, times u"


def test_bursts_at_random_times_are_intermittent_with_their_times():
    bursts = np.zeros(N)
    for begin in (1234, 4711):
        bursts[begin : begin + 60] = 5.0 * np.random.default_rng(begin).standard_normal(60)
    found = channel(NOISE + bursts)

    assert not found.is_adequate
    assert {round(t, 1) for t in found.events} >= {1.2, 4.7}


def test_strikes_that_ring_on_are_told_with_their_times_and_noise_of_any_size_has_none():
    """Five strikes of 30 ms on a mode of 6.7 Hz and 3 % damping: its power is everywhere."""
    pole = np.exp((-0.03 + 1j) * 2.0 * np.pi * 6.7e-3)
    force = np.zeros(N)
    begins = np.array([610, 1870, 3410, 4930, 6260])
    for begin in begins:
        force[begin : begin + 30] = 0.05
    found = channel(NOISE + lfilter([1.0], [1.0, -2.0 * pole.real, abs(pole) ** 2], force))

    assert found.ratio > 3.5
    assert not found.events
    away = np.abs(1e3 * np.array(found.strikes)[:, None] - begins)
    assert away.min(axis=0).max() < 60.0
    assert away.min(axis=1).max() < 100.0
    assert not channel(NOISE).strikes


def test_what_is_left_at_some_times_more_than_at_others_is_no_noise_of_any_colour():
    """A resonance of 8 Hz, shaken at random: steadily, or in the first half of the time alone."""
    pole = np.exp((-0.3 + 1j) * 2.0 * np.pi * 8e-3)
    shaken = np.random.default_rng(8).standard_normal(N)
    rest = lfilter([0.004], [1.0, -2.0 * pole.real, abs(pole) ** 2], shaken)
    steady = channel(NOISE + rest)
    uneven = channel(NOISE + np.where(T < 4.0, 1.4 * rest, 0.2 * rest))

    assert steady.ratio > 1.3
    assert steady.is_adequate
    assert uneven.ratio < 3.5
    assert uneven.is_uneven
    assert not uneven.is_adequate

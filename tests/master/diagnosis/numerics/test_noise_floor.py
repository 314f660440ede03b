"""The noise floor of a channel: which evidence, and which number."""

from __future__ import annotations

import numpy as np
import pytest

from master.diagnosis.numerics.noise_floor import Evidence, colour_of, from_differences, noise_floor, step_of

N = 10_000
T = np.arange(N) * 1e-3
MOTION = 100.0 * np.sin(2.0 * np.pi * 0.731 * T) + 30.0 * np.sin(2.0 * np.pi * 3.17 * T + 1.0)


def noise(deviation, seed=1, n=N):
    return np.random.default_rng(seed).normal(0.0, deviation, n)


def test_differences_see_white_noise_below_a_large_motion():
    floor = noise_floor([MOTION + noise(0.5)], [MOTION[:, None]], 1e-3)

    assert floor.evidence is Evidence.DIFFERENCES
    assert floor.value == pytest.approx(0.5, rel=0.03)
    assert from_differences(MOTION) < 1e-4


def test_a_stretch_at_rest_sees_coloured_noise_that_differences_miss():
    coloured = np.convolve(noise(1.0, n=N + 4), np.full(5, 0.2), "valid")
    motion = np.where(T < 5.0, 0.0, MOTION)

    floor = noise_floor([motion + coloured], [motion[:, None]], 1e-3)

    assert floor.evidence is Evidence.REST
    assert floor.value == pytest.approx(1.0 / np.sqrt(5.0), rel=0.1)
    assert from_differences(motion + coloured) < 0.7 * floor.value


def test_a_channel_that_rings_while_nothing_drives_it_is_not_at_rest():
    ringing = 50.0 * np.exp(-0.05 * T) * np.sin(2.0 * np.pi * 5.0 * T)

    floor = noise_floor([ringing + noise(0.5)], [np.zeros((N, 1))], 1e-3)

    assert floor.evidence is Evidence.DIFFERENCES
    assert floor.value == pytest.approx(0.5, rel=0.03)


def test_periods_that_repeat_show_the_spread_between_them():
    period = 2000
    motion = np.tile(np.cumsum(noise(1.0, seed=2, n=period)), 5)
    coloured = np.convolve(noise(1.0, n=N + 9), np.full(10, 0.1), "valid")

    floor = noise_floor([motion + coloured], [motion[:, None]], 1e-3)

    assert floor.evidence is Evidence.REPETITION
    assert floor.value == pytest.approx(np.sqrt(0.1), rel=0.1)


def test_what_starts_otherwise_or_comes_back_to_another_place_is_no_noise_of_a_repetition():
    """A motor: a current that settles within the first period, and an angle that has gone on meanwhile."""
    motion = np.tile(MOTION[: N // 2], 2)
    settling = 20.0 * np.exp(-T / 0.3)
    place = 7.0 * T + 3.0

    for channel in (motion + settling, motion + place):
        floor = noise_floor([channel + noise(0.5)], [motion[:, None]], 1e-3)
        assert floor.evidence is Evidence.REPETITION
        assert floor.value == pytest.approx(0.5, rel=0.03)


def test_a_motion_that_never_settles_does_not_repeat():
    """A pendulum that was not started on its periodic motion swings on for longer than the recording."""
    motion = np.tile(MOTION[: N // 2], 2)
    swing = 20.0 * np.exp(-T / 30.0) * np.sin(2.0 * np.pi * 0.77 * T)

    floor = noise_floor([motion + swing + noise(0.5)], [motion[:, None]], 1e-3)

    assert floor.evidence is Evidence.DIFFERENCES
    assert floor.value == pytest.approx(0.5, rel=0.03)


def test_recordings_of_the_same_motion_are_repetitions():
    driving = [MOTION[:, None], MOTION[:, None]]

    floor = noise_floor([MOTION + noise(0.5), MOTION + noise(0.5, seed=2)], driving, 1e-3)

    assert floor.evidence is Evidence.REPETITION
    assert floor.value == pytest.approx(0.5, rel=0.03)


def test_a_converter_is_a_floor_by_itself():
    step = 2.0

    floor = noise_floor([step * np.round(MOTION / step)], [MOTION[:, None]], 1e-3)

    assert floor.step == pytest.approx(step)
    assert floor.value >= step / np.sqrt(12.0)
    assert step_of(np.round(MOTION, 2)) == pytest.approx(0.01)
    assert step_of(MOTION) == 0.0


def test_colour_names_hum_pink_and_spikes():
    hum = noise(1.0) + np.sin(2.0 * np.pi * 50.0 * T)
    spiky = noise(1.0)
    spiky[[100, 2000, 7000]] = 40.0

    assert colour_of(noise(1.0), 1e-3).words == "white"
    assert colour_of(hum, 1e-3).lines == pytest.approx([50.0], abs=1.0)
    assert colour_of(np.cumsum(noise(1.0)), 1e-3).words.startswith("coloured")
    assert colour_of(spiky, 1e-3).spikes == 3

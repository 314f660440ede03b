import math

import numpy as np
import pytest
from scipy.fft import prev_fast_len

from master.evaluation.modes import _largest_singular, _smooth, dominant_mode, modes, project

STEP = 1e-3
TIME = STEP * np.arange(5001)


def damped(zeta, omega, amplitude=1.0, phase=0.0, time=TIME):
    """A exp(-zeta omega t) cos(omega sqrt(1 - zeta^2) t + phase)."""
    rate = omega * math.sqrt(1.0 - zeta * zeta)
    return amplitude * np.exp(-zeta * omega * time) * np.cos(rate * time + phase)


@pytest.mark.parametrize("zeta", [-0.1, -0.02, 0.0, 1e-4, 0.01, 0.05, 0.3])
@pytest.mark.parametrize("omega", [3.0, 12.0, 60.0])
def test_the_damping_of_an_exact_signal_is_found(zeta, omega):
    mode = dominant_mode(damped(zeta, omega, 0.01, 0.7), STEP)

    assert mode.zeta == pytest.approx(zeta, abs=1e-9)
    assert mode.frequency == pytest.approx(omega * math.sqrt(1 - zeta**2) / (2 * math.pi), rel=1e-9)


def test_growth_per_cycle_is_the_ratio_of_two_peaks_one_cycle_apart():
    zeta = -0.05
    mode = dominant_mode(damped(zeta, 12.0), STEP)

    assert mode.growth_per_cycle == pytest.approx(
        math.exp(2 * math.pi * 0.05 / math.sqrt(1 - 0.0025)), rel=1e-8
    )


def test_an_offset_does_not_change_the_mode():
    mode = dominant_mode(damped(0.02, 12.0) + 5.0, STEP)

    assert mode.zeta == pytest.approx(0.02, abs=1e-9)


def test_of_two_modes_the_stronger_one_dominates():
    slow, fast = damped(0.01, 6.0, 1.0), damped(0.04, 31.0, 0.4, 1.0)
    mode = dominant_mode(slow + fast, STEP)

    assert mode.zeta == pytest.approx(0.01, abs=1e-8)
    assert mode.frequency == pytest.approx(6.0 * math.sqrt(1 - 1e-4) / (2 * math.pi), abs=1e-8)
    poles, _ = modes(slow + fast, STEP)
    assert min(abs(poles - complex(-0.04 * 31, 31 * math.sqrt(1 - 0.0016)))) < 1e-6


def test_noise_of_a_thousandth_moves_the_damping_by_less_than_a_thousandth():
    noise = 1e-3 * np.random.default_rng(1).standard_normal(TIME.size)
    mode = dominant_mode(damped(0.02, 12.0) + noise, STEP)

    assert mode.zeta == pytest.approx(0.02, abs=1e-3)


@pytest.mark.parametrize(
    "y", [np.zeros(500), np.full(500, 3.0), np.exp(-2e-3 * np.arange(500)), 1e-3 * np.arange(500)]
)
def test_a_signal_that_does_not_oscillate_has_no_mode(y):
    assert dominant_mode(y, STEP) is None


def test_amplitude_and_phase_stand_at_the_first_sample():
    pole = complex(-0.2, 11.0)
    amplitudes = project(
        2.0 * np.exp(-0.2 * TIME) * np.cos(11.0 * TIME + 0.5), STEP, np.array([pole, pole.conjugate()])
    )

    assert amplitudes[0] == pytest.approx(np.exp(0.5j), abs=1e-10)


def test_a_signal_that_grows_by_60_decades_is_still_measured():
    mode = dominant_mode(damped(-0.5, 60.0), STEP)

    assert mode.zeta == pytest.approx(-0.5, abs=1e-8)


def test_the_length_of_a_fast_transform_is_that_of_scipy():
    lengths = [*range(1, 400), 997, 1001, 9973, 10_001, 65_537]

    assert [_smooth(n) for n in lengths] == [prev_fast_len(n, real=True) for n in lengths]


@pytest.mark.parametrize("n", [50, 120, 1000, 10_001])
@pytest.mark.parametrize(
    "rates", [[-0.002 + 0.1j, -0.002 - 0.1j], [0.003 + 0.2j, 0.003 - 0.2j, -0.05], [-0.01 + 0.3j]]
)
def test_amplitudes_by_given_poles_are_those_of_least_squares(n, rates):
    poles = np.array(rates, dtype=complex)
    y = np.random.default_rng(n).normal(size=n)
    basis = np.exp(np.arange(n)[:, None] * poles)
    weights = np.exp(-np.maximum(poles.real, 0.0) * (n - 1))
    expected = np.linalg.lstsq(basis * weights, y.astype(complex), rcond=None)[0] * weights

    assert project(y, 1.0, poles) == pytest.approx(expected, rel=1e-9, abs=1e-12 * np.abs(expected).max())


@pytest.mark.parametrize("noise", [0.0, 1e-12, 1e-6, 1e-2])
def test_the_largest_singular_values_and_their_directions_are_those_of_the_whole_matrix(noise):
    t = np.arange(296)
    y = np.exp(-0.002 * t) * np.cos(0.5 * t) + 1e-5 * np.exp(-0.01 * t) * np.sin(1.1 * t)
    windows = np.lib.stride_tricks.sliding_window_view(
        y + noise * np.random.default_rng(1).normal(size=296), 99
    )
    _, expected, right = np.linalg.svd(windows, full_matrices=False)
    singular, found = _largest_singular(windows, 11)

    assert singular[:4] == pytest.approx(expected[:4], rel=1e-9)
    assert found[:4] @ right[:4].T @ right[:4] == pytest.approx(found[:4], abs=1e-7 if noise < 1e-5 else 1e-2)

"""
Damped modes of a signal by the matrix pencil: y(t) = sum a_i exp(s_i t).

Source: Hua, Sarkar, Matrix pencil method for estimating parameters of exponentially damped/undamped
sinusoids in noise, IEEE Trans. ASSP 38 (1990), 814-824.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

_SAMPLES_PER_CYCLE = 12
_FEWEST_SAMPLES = 300
_MOST_COLUMNS = 120
_LARGEST_ORDER = 8
_SMALLEST_SINGULAR_VALUE = 1e-10
_SMALLEST_SHARE = 1e-6


@dataclass(frozen=True)
class Mode:
    """One oscillating mode: pole s [1/s] with positive imaginary part, amplitude at t = 0."""

    pole: complex
    amplitude: complex

    @property
    def zeta(self) -> float:
        """Damping ratio -Re(s)/|s|; negative: growing."""
        return -self.pole.real / abs(self.pole)

    @property
    def frequency(self) -> float:
        """Frequency of the damped oscillation Im(s)/(2 pi) [Hz]."""
        return self.pole.imag / (2.0 * math.pi)

    @property
    def growth_per_cycle(self) -> float:
        """Ratio of amplitudes one cycle apart, exp(-2 pi zeta/sqrt(1 - zeta^2))."""
        return math.exp(2.0 * math.pi * self.pole.real / self.pole.imag)


def dominant_mode(y: Floats, step: float) -> Mode | None:
    """
    Find the oscillating mode with the most energy in y, shape (n,), sampled every `step` s.

    None if nothing in the signal oscillates.
    """
    poles, amplitudes = modes(y, step)
    powers = [_energy(s, a, len(y) * step) for s, a in zip(poles, amplitudes, strict=True)]
    oscillating = [i for i, s in enumerate(poles) if s.imag * len(y) * step > math.pi]
    if not oscillating:
        return None
    best = max(oscillating, key=lambda i: powers[i])
    if powers[best] < _SMALLEST_SHARE * sum(powers):
        return None
    return Mode(complex(poles[best]), complex(amplitudes[best]))


def modes(y: Floats, step: float) -> tuple[NDArray[np.complex128], NDArray[np.complex128]]:
    """Poles [1/s] and complex amplitudes at the first sample; a conjugate pair counts as two."""
    stride = _stride(y, step)
    short = _low_passed(y, stride)[::stride]
    z = _pencil(short / (np.max(np.abs(short)) or 1.0))
    z = z[np.abs(z) > 0.0]
    poles = np.log(z.astype(complex)) / (stride * step)
    return poles, project(y, step, poles)


def _stride(y: Floats, step: float) -> int:
    """Return the largest stride at which the samples still show the strongest oscillation well."""
    n = np.arange(len(y))
    straight = np.polyval(np.polyfit(n, y, 1), n)
    spectrum = np.abs(np.fft.rfft((y - straight) * np.hanning(len(y))))
    cycles = max(1, int(np.argmax(spectrum)))
    return max(1, min(len(y) // (_SAMPLES_PER_CYCLE * cycles), len(y) // _FEWEST_SAMPLES))


def _low_passed(y: Floats, stride: int) -> Floats:
    """
    Take out what `stride` would alias, by a windowed sinc without the ends where it fills.

    Such a filter changes the amplitude of each exponential and leaves its pole exactly as it is.
    """
    if stride == 1:
        return y
    n = np.arange(-4 * stride, 4 * stride + 1)
    kernel = np.sinc(0.8 * n / stride) * np.hanning(len(n) + 2)[1:-1]
    return np.convolve(y, kernel / kernel.sum(), mode="valid")


def project(y: Floats, step: float, poles: NDArray[np.complex128]) -> NDArray[np.complex128]:
    """Complex amplitudes at the first sample of given poles, least squares."""
    t = step * np.arange(len(y))
    scale = np.exp(-np.maximum(poles.real, 0.0) * t[-1])
    basis = np.exp(poles * t[:, None] + np.log(scale))
    amplitudes: NDArray[np.complex128] = np.linalg.lstsq(basis, y.astype(complex), rcond=None)[0]
    amplitudes *= scale
    return amplitudes


def _pencil(y: Floats) -> NDArray[np.complex128]:
    n_columns = min(len(y) // 3, _MOST_COLUMNS)
    hankel = np.lib.stride_tricks.sliding_window_view(y, n_columns + 1)
    _, singular, right = np.linalg.svd(np.linalg.qr(hankel, mode="r"), full_matrices=False)
    order = int(np.sum(singular > _SMALLEST_SINGULAR_VALUE * singular[0]))
    v = right[: max(1, min(order, _LARGEST_ORDER))].T
    return np.linalg.eigvals(np.linalg.lstsq(v[:-1], v[1:], rcond=None)[0]).astype(complex)


def _energy(pole: complex, amplitude: complex, duration: float) -> float:
    """Integral of |a exp(s t)|^2 over the record."""
    rate = 2.0 * pole.real * duration
    share = duration if abs(rate) < 1e-9 else duration * math.expm1(min(rate, 700.0)) / rate
    return abs(amplitude) ** 2 * share

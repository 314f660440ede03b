"""
Damped modes of a signal by the matrix pencil: y(t) = sum a_i exp(s_i t).

Source: Hua, Sarkar, Matrix pencil method for estimating parameters of exponentially damped/undamped
sinusoids in noise, IEEE Trans. ASSP 38 (1990), 814-824.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

_SAMPLES_PER_CYCLE = 12
_FEWEST_SAMPLES = 300
_MOST_COLUMNS = 120
_LARGEST_ORDER = 8
_SMALLEST_SINGULAR_VALUE = 1e-10
_SMALLEST_SHARE = 1e-6
_LARGEST_CONDITION = 1e8


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
    return dominant_of(*modes(y, step), len(y) * step)


def dominant_of(
    poles: NDArray[np.complex128], amplitudes: NDArray[np.complex128], duration: float
) -> Mode | None:
    """Find the oscillating mode with the most energy over a duration [s] among those of a signal."""
    powers = [_energy(s, a, duration) for s, a in zip(poles, amplitudes, strict=True)]
    oscillating = [i for i, s in enumerate(poles) if s.imag * duration > math.pi]
    if not oscillating:
        return None
    best = max(oscillating, key=lambda i: powers[i])
    if powers[best] < _SMALLEST_SHARE * sum(powers):
        return None
    return Mode(complex(poles[best]), complex(amplitudes[best]))


def modes(y: Floats, step: float) -> tuple[NDArray[np.complex128], NDArray[np.complex128]]:
    """Poles [1/s] and complex amplitudes at the first sample; a conjugate pair counts as two."""
    stride = _stride(y, step)
    short = _low_passed(y, stride)
    z = _pencil(short / (np.max(np.abs(short)) or 1.0))
    z = z[np.abs(z) > 0.0]
    poles = np.log(z.astype(complex)) / (stride * step)
    return poles, project(y, step, poles)


def _stride(y: Floats, step: float) -> int:
    """Return the largest stride at which the samples still show the strongest oscillation well."""
    n = np.arange(len(y)) - 0.5 * (len(y) - 1)
    centred = y - np.mean(y)
    straight = n * (np.dot(n, centred) / np.dot(n, n))
    spectrum = np.abs(np.fft.rfft((centred - straight) * _hanning(len(y))))
    cycles = max(1, int(np.argmax(spectrum)))
    return max(1, min(len(y) // (_SAMPLES_PER_CYCLE * cycles), len(y) // _FEWEST_SAMPLES))


@lru_cache(maxsize=4)
def _hanning(n: int) -> Floats:
    return np.hanning(n)


def _low_passed(y: Floats, stride: int) -> Floats:
    """
    Return every `stride`-th sample of what has nothing left that this would alias.

    That is taken out by a windowed sinc, without the ends where it fills.

    Such a filter changes the amplitude of each exponential and leaves its pole exactly as it is.
    """
    if stride == 1:
        return y
    n = np.arange(-4 * stride, 4 * stride + 1)
    kernel = np.sinc(0.8 * n / stride) * np.hanning(len(n) + 2)[1:-1]
    windows = np.lib.stride_tricks.sliding_window_view(y, len(kernel))[::stride]
    found: Floats = windows @ (kernel / kernel.sum())[::-1]
    return found


def project(y: Floats, step: float, poles: NDArray[np.complex128]) -> NDArray[np.complex128]:
    """Complex amplitudes at the first sample of given poles, least squares."""
    scale = np.exp(-np.maximum(poles.real, 0.0) * step * (len(y) - 1))
    basis = _exponentials(poles * step, len(y)) * scale
    amplitudes = _least_squares(basis, y)
    amplitudes *= scale
    return amplitudes


def _exponentials(exponents: NDArray[np.complex128], n: int) -> NDArray[np.complex128]:
    """Return exp(k s) for k below n and each s, shape (n, len(s)), by few exponentials and a product each."""
    width = math.isqrt(n) + 1
    coarse = np.exp(width * np.arange(-(-n // width))[:, None] * exponents)
    fine = np.exp(np.arange(width)[:, None] * exponents)
    return (coarse[:, None, :] * fine).reshape(len(coarse) * width, len(exponents))[:n]


def _least_squares(basis: NDArray[np.complex128], y: Floats) -> NDArray[np.complex128]:
    """
    Solve a tall system; by normal equations with a step of refinement where they are good enough for that.

    Their condition is the square of the basis's: refinement makes up for that below the bound here.
    """
    norms = np.sqrt(np.sum(basis.real**2 + basis.imag**2, axis=0))
    if len(norms) > 0 and np.all(norms > 0.0) and np.all(np.isfinite(norms)):
        adjoint = basis.conj().T
        normal = (adjoint @ basis) / np.outer(norms, norms)
        if np.linalg.cond(normal) < _LARGEST_CONDITION:
            found = np.linalg.solve(normal, (adjoint @ y) / norms) / norms
            rest = y - basis @ found
            return np.asarray(found + np.linalg.solve(normal, (adjoint @ rest) / norms) / norms)
    return np.asarray(np.linalg.lstsq(basis, y.astype(complex), rcond=None)[0])


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

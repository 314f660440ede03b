"""
Damped modes of a signal by the matrix pencil: y(t) = sum a_i exp(s_i t).

Source: Hua, Sarkar, Matrix pencil method for estimating parameters of exponentially damped/undamped
sinusoids in noise, IEEE Trans. ASSP 38 (1990), 814-824.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Complexes = NDArray[np.complex128]

_SAMPLES_PER_CYCLE = 12
_FEWEST_SAMPLES = 300
_MOST_COLUMNS = 120
_LARGEST_ORDER = 8
_SPARE = 3
_SMALLEST_SINGULAR_VALUE = 1e-10
_SMALLEST_SHARE = 1e-6
_LARGEST_CONDITION = 1e8
_GOOD_CONDITION = 1e2
_ROUNDING = 1e-13
_SMALLEST_REST = 1e-3


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


def dominant_of(poles: Complexes, amplitudes: Complexes, duration: float) -> Mode | None:
    """Find the oscillating mode with the most energy over a duration [s] among those of a signal."""
    powers = [_energy(s, a, duration) for s, a in zip(poles.tolist(), amplitudes.tolist(), strict=True)]
    oscillating = [i for i, s in enumerate(poles.tolist()) if s.imag * duration > math.pi]
    if not oscillating:
        return None
    best = max(oscillating, key=lambda i: powers[i])
    if powers[best] < _SMALLEST_SHARE * sum(powers):
        return None
    return Mode(complex(poles[best]), complex(amplitudes[best]))


def modes(y: Floats, step: float) -> tuple[Complexes, Complexes]:
    """Poles [1/s] and complex amplitudes at the first sample; a conjugate pair counts as two."""
    poles = poles_of(y, step)
    return poles, project(y, step, poles)


def poles_of(y: Floats, step: float) -> Complexes:
    """Poles [1/s] of a signal; a conjugate pair counts as two."""
    stride = _stride(y, step)
    short = _low_passed(y, stride)
    z = _pencil(short / (np.max(np.abs(short)) or 1.0))
    z = z[np.abs(z) > 0.0]
    return np.asarray(np.log(z.astype(complex)) / (stride * step))


@lru_cache(maxsize=64)
def _smooth(n: int) -> int:
    """Return the largest number up to n without prime factors above 5: its Fourier transform is fast."""
    largest = 1
    fives = 1
    while fives <= n:
        threes = fives
        while threes <= n:
            largest = max(largest, threes << ((n // threes).bit_length() - 1))
            threes *= 3
        fives *= 5
    return largest


def _stride(y: Floats, step: float) -> int:
    """Return the largest stride at which the samples still show the strongest oscillation well."""
    n = _smooth(len(y))
    ramp = _ramp(n)
    centred = y[:n] - np.mean(y[:n])
    centred -= ramp * (np.dot(ramp, centred) / np.dot(ramp, ramp))
    centred *= _hanning(n)
    spectrum = np.abs(np.fft.rfft(centred))
    cycles = max(1, int(np.argmax(spectrum)))
    return max(1, min(len(y) // (_SAMPLES_PER_CYCLE * cycles), len(y) // _FEWEST_SAMPLES))


@lru_cache(maxsize=4)
def _ramp(n: int) -> Floats:
    return np.asarray(np.arange(n) - 0.5 * (n - 1), dtype=np.float64)


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
    kernel = _low_pass(stride)
    n_pieces = kernel.shape[1]
    n_found = (len(y) - (n_pieces - 1) * stride - 1) // stride + 1
    blocks = np.zeros((n_found + n_pieces - 1, stride))
    blocks.reshape(-1)[: len(y)] = y[: blocks.size]
    products = blocks @ kernel  # of each block with each piece of the kernel
    found = np.zeros(n_found)
    for piece in range(n_pieces):
        found += products[piece : piece + n_found, piece]
    return found


@lru_cache(maxsize=64)
def _low_pass(stride: int) -> Floats:
    """Return a windowed sinc over eight strides and a sample in pieces of one, shape (stride, 9)."""
    n = np.arange(-4 * stride, 4 * stride + 1)
    kernel = np.sinc(0.8 * n / stride) * np.hanning(len(n) + 2)[1:-1]
    pieces = np.zeros((9, stride))
    pieces.reshape(-1)[: len(n)] = kernel / kernel.sum()
    return np.ascontiguousarray(pieces.T)


def project(y: Floats, step: float, poles: Complexes) -> Complexes:
    """Complex amplitudes at the first sample of given poles, least squares."""
    return Projection(poles, step, len(y)).amplitudes(y)


class Projection:
    """
    Least squares of signals of one length by given poles [1/s], sampled every `step` s.

    By normal equations where they are good enough for that: their condition is the square of the basis's,
    which a step of refinement makes up for below the bound here; below a lower one nothing is lost.
    """

    def __init__(self, poles: Complexes, step: float, n: int) -> None:
        self._basis = _Exponentials(poles * step, n)
        products = self._basis.products()
        norms = np.sqrt(np.diagonal(products).real)
        self._norms = norms
        self._inverse: Complexes | None = None
        self._is_refined = False
        if len(poles) and np.all(norms > 0.0) and np.all(np.isfinite(norms)):
            weights, vectors = np.linalg.eigh(products / np.outer(norms, norms))
            if weights[-1] < _LARGEST_CONDITION * weights[0]:
                self._inverse = (vectors / weights) @ vectors.conj().T
                self._is_refined = weights[-1] > _GOOD_CONDITION * weights[0]

    def amplitudes(self, y: Floats) -> Complexes:
        """Complex amplitudes at the first sample of y, shape (n,)."""
        basis = self._basis
        if self._inverse is None:
            found = np.linalg.lstsq(basis.matrix(), y.astype(complex), rcond=None)[0]
            return np.asarray(found * basis.scale)
        found = self._solved(y)
        if self._is_refined:
            found += self._solved(y - basis.sum(found))
        return np.asarray(found * basis.scale)

    def _solved(self, y: NDArray[Any]) -> Complexes:
        assert self._inverse is not None
        return np.asarray(self._inverse @ (self._basis.moments(y) / self._norms) / self._norms)


class _Exponentials:
    """
    The sequences exp(k s), k below n, of some exponents s; one that grows is scaled to end at size 1.

    Sample k is row k // width and place k % width: an exponential of each is all that is computed, and sums
    over k are products of small matrices.
    """

    def __init__(self, exponents: Complexes, n: int) -> None:
        growth = np.maximum(exponents.real, 0.0) * (n - 1)
        self.scale = np.exp(-growth)
        self._n = n
        self._width = math.isqrt(n) + 1
        self._is_paired = _is_paired(exponents)
        n_rows = -(-n // self._width)
        self._coarse = np.exp(self._width * np.arange(n_rows)[:, None] * exponents - growth)
        self._fine = np.exp(np.arange(self._width)[:, None] * exponents)

    def matrix(self) -> Complexes:
        """All samples, shape (n, number of exponents)."""
        samples = self._coarse[:, None, :] * self._fine
        return np.asarray(samples.reshape(samples.shape[0] * self._width, samples.shape[2])[: self._n])

    @np.errstate(over="ignore", invalid="ignore")  # of what grows so fast, the basis itself is good enough
    def products(self) -> Complexes:
        """Inner products of all pairs: those of rows times those within one; the last is short."""
        full = self._coarse[:-1]
        last = self._coarse[-1]
        within = self._fine.conj().T @ self._fine
        short = self._fine[: self._n - len(full) * self._width]
        within_last = short.conj().T @ short
        return np.asarray((full.conj().T @ full) * within + np.outer(last.conj(), last) * within_last)

    def moments(self, y: NDArray[Any]) -> Complexes:
        """Inner product of each sequence with y, shape (n,)."""
        if np.iscomplexobj(y):
            return self.moments(y.real.copy()) + 1j * self.moments(y.imag.copy())
        rows = np.empty((len(self._coarse), self._width))
        cells = rows.reshape(-1)
        cells[: self._n] = y
        cells[self._n :] = 0.0
        within = (rows @ self._fine.view(np.float64)).view(np.complex128)
        return np.asarray(np.sum(self._coarse * within, axis=0).conj())

    def sum(self, weights: Complexes) -> NDArray[Any]:
        """Weighted sum of all sequences, shape (n,); real if each has its conjugate next to it."""
        weighted = self._coarse * weights
        if not self._is_paired:
            return np.asarray((weighted @ self._fine.T).reshape(-1)[: self._n])
        halves = weighted.conj().view(np.float64) @ self._fine.view(np.float64).T
        return np.asarray(halves.reshape(-1)[: self._n])


def _is_paired(exponents: Complexes) -> bool:
    """Whether each exponent is real or has its conjugate next to it, as eigenvalues of real matrices have."""
    others = iter(exponents)
    return all(s.imag == 0.0 or next(others, None) == s.conjugate() for s in others)


def _pencil(y: Floats) -> Complexes:
    n_columns = min(len(y) // 3, _MOST_COLUMNS)
    hankel = _rows_of_windows(y, n_columns + 1)
    singular, right = _largest_singular(hankel, _LARGEST_ORDER + _SPARE)
    order = int(np.sum(singular > _SMALLEST_SINGULAR_VALUE * singular[0]))
    v = right[: max(1, min(order, _LARGEST_ORDER))].T
    return np.linalg.eigvals(_shift(v)).astype(complex)


def _rows_of_windows(y: Floats, width: int) -> Floats:
    """Return all windows of y, each a row after the one before, shape (windows, width)."""
    n = len(y) - width + 1
    return np.ndarray((n, width), y.dtype, np.ascontiguousarray(y), 0, (y.itemsize, y.itemsize)).copy()


def _shift(v: Floats) -> Floats:
    """
    Return the matrix that takes all rows but the last to all but the first, least squares.

    The columns are orthonormal, so that the inverse of the products of those without their last row is known.
    """
    last = v[-1]
    rest = 1.0 - np.dot(last, last)
    if rest < _SMALLEST_REST:
        return np.asarray(np.linalg.lstsq(v[:-1], v[1:], rcond=None)[0])
    products = v[:-1].T @ v[1:]
    return np.asarray(products + np.outer(last / rest, last @ products))


def _largest_singular(columns: Floats, n: int) -> tuple[Floats, Floats]:
    """
    Return the n largest singular values and their right vectors, shape (n, columns).

    The images of a few directions tell whether the columns are of a lower rank but for rounding, as those of
    a signal without noise: then they span all that there is. Else the eigenvectors of the products of all
    columns know the directions above the root of the rounding. Their image spans what the matrix itself makes
    largest, the small ones too; within that they are exact.

    Source of the first: Halko, Martinsson, Tropp, Finding structure with randomness, SIAM Review 53 (2011).
    """
    n_columns = columns.shape[1]
    if n >= n_columns:
        _, singular, right = np.linalg.svd(columns, full_matrices=False)
        return singular, right
    span, triangle = np.linalg.qr(columns @ _directions(n_columns, n))
    sizes = np.abs(np.diagonal(triangle))
    if sizes[-1] > _ROUNDING * sizes[0]:
        vectors = np.linalg.eigh(columns.T @ columns)[1][:, ::-1]  # as fast as SciPy's for the largest alone
        span = np.linalg.qr(columns @ vectors[:, :n])[0]
    _, singular, right = np.linalg.svd(span.T @ columns, full_matrices=False)
    return singular, right


@lru_cache(maxsize=64)
def _directions(n_rows: int, n: int) -> Floats:
    """Return n directions that no signal prefers, shape (rows, n)."""
    return np.random.default_rng(1).standard_normal((n_rows, n))


def _energy(pole: complex, amplitude: complex, duration: float) -> float:
    """Integral of |a exp(s t)|^2 over the record."""
    rate = 2.0 * pole.real * duration
    share = duration if abs(rate) < 1e-9 else duration * math.expm1(min(rate, 700.0)) / rate
    size = abs(amplitude)
    return size * size * share

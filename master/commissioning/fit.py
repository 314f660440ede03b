"""
Batch output-error fit of a transfer function to a record, in the frequency domain.

    Y(f) = G(j 2 pi f, theta) U(f) + T(j 2 pi f)/D + E(f),   f the bins up to a highest frequency

    mean(y) = G(0, theta) mean(u) + e,   e with the deviation of what is at rest, where that is known

T is a polynomial: what begins before the record and is not over at its end is a rational function with the
denominator of G, whose coefficients are nuisances that least squares solves. E is white: the error of a bin
has the deviation of a sample in its real and imaginary part each, since the transform is scaled by sqrt(2/n).

Deviations are those of least squares, (J' J)^-1 s^2 with all nuisances in J; s is the larger of the noise
of the signal, seen where no motion is (above the band), and of what the fit leaves.
Source   Pintelon, Schoukens, System Identification: A Frequency Domain Approach (2012), Secs. 2.6, 9.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

Floats = NDArray[np.float64]
Complexes = NDArray[np.complex128]

Response = Callable[[Complexes, Floats], Complexes]
"""From s = j w, shape (n,), and the parameters to what is seen per unit of input, shape (n,)."""

RESOLUTION = 3e-4
"""Share of a signal's rms below which no fit is judged: the forms of the models are not truer than that."""
CLEAR = 4.0
"""Multiple of the band's end from which on a signal is noise."""
STEP = 1e-6


@dataclass(frozen=True)
class Record:
    """
    Input and output of one subsystem, shape (n,), every `period` s; up to `highest` Hz they are used.

    `zero`: deviation of the output where the input is 0, in its unit; inf: what is at rest tells nothing.
    """

    u: Floats
    y: Floats
    period: float
    highest: float
    zero: float = np.inf

    def deviation_at_rest(self, noise: float) -> float:
        """Return the deviation of the mean output, of a zero, of noise and of a form that is not exact."""
        mean = float(np.mean(self.y))
        return float(np.linalg.norm([self.zero, noise / np.sqrt(len(self.y)), RESOLUTION * mean]))

    def left_at_rest(self, form: Form, theta: Floats) -> float:
        """Return the part of the mean output that G(0) leaves."""
        static = form.response(np.zeros(1, dtype=np.complex128), theta)[0].real
        return float(np.mean(self.y) - static * np.mean(self.u))


@dataclass(frozen=True)
class Form:
    """
    A transfer function: its response, its denominator, and how many terms what begins before the record has.

    Parameters are within `lower` and `upper`, and known as `centre` with the deviations `spread` (inf: not).
    """

    response: Response
    denominator: Response
    n_transient: int
    lower: Floats
    upper: Floats
    centre: Floats
    spread: Floats


@dataclass(frozen=True)
class Fit:
    """
    Parameters with their covariance; `noise` and `rms` are of a sample, in the unit of the output.

    `pulled`: parameters against what was known of them, in deviations of that. `frequency` [Hz], `measured`
    and `fitted`: responses in the bins, for people.
    """

    theta: Floats
    covariance: Floats
    noise: float
    rms: float
    cost: float
    pulled: Floats
    frequency: Floats
    measured: Complexes
    fitted: Complexes

    @property
    def ratio(self) -> float:
        """What the fit leaves in terms of the noise: about 1 where the model is right."""
        return self.rms / self.noise

    def deviation(self, of: Callable[[Floats], float]) -> float:
        """Return the standard deviation of a function of the parameters, to first order."""
        steps = STEP * np.maximum(np.abs(self.theta), 1e-3)
        slope = np.array(
            [
                (of(self.theta + e) - of(self.theta - e)) / (2.0 * h)
                for e, h in zip(np.diag(steps), steps, strict=True)
            ]
        )
        return float(np.sqrt(max(slope @ self.covariance @ slope, 0.0)))


def fit(record: Record, form: Form, starts: Sequence[Floats]) -> Fit:
    """Fit from several starts, and return the best one."""
    n = len(record.y)
    frequency: Floats = np.asarray(np.fft.rfftfreq(n, record.period), dtype=np.float64)
    used = (frequency > 0.0) & (frequency <= record.highest)
    s: Complexes = np.asarray(2j * np.pi * frequency[used], dtype=np.complex128)
    scale = np.sqrt(2.0 / n)
    U: Complexes = np.asarray(scale * np.fft.rfft(record.u - record.u[0])[used], dtype=np.complex128)
    Y: Complexes = np.asarray(scale * np.fft.rfft(record.y - np.mean(record.y))[used], dtype=np.complex128)
    noise = max(noise_of(record), RESOLUTION * float(np.std(record.y)))

    def at_rest(theta: Floats) -> Floats:
        if not np.isfinite(record.zero):
            return np.zeros(0)
        return np.array([record.left_at_rest(form, theta) / record.deviation_at_rest(noise)])

    def left(theta: Floats) -> Floats:
        difference = _stacked(Y - form.response(s, theta) * U)
        basis = _basis(s, theta, form)
        unexplained = difference - basis @ np.linalg.lstsq(basis, difference, rcond=None)[0]
        return np.concatenate([unexplained / noise, at_rest(theta), (theta - form.centre) / form.spread])

    bounds = (form.lower, form.upper)
    tried = [
        least_squares(left, np.clip(start, *bounds), bounds=bounds, x_scale="jac", xtol=1e-13, ftol=1e-13)
        for start in starts
    ]
    best = min(tried, key=lambda one: float(one.cost))
    theta: Floats = np.asarray(best.x)
    J = np.column_stack([_slopes(lambda p: _stacked(form.response(s, p) * U), theta), _basis(s, theta, form)])
    n_free = max(1, J.shape[0] - J.shape[1])
    n_data = J.shape[0]
    rms = float(noise * np.linalg.norm(left(theta)[:n_data]) / np.sqrt(n_free))
    known = np.zeros((len(theta), J.shape[1]))
    np.fill_diagonal(known, 1.0 / form.spread)
    of_rest = np.zeros((len(at_rest(theta)), J.shape[1]))
    of_rest[:, : len(theta)] = _slopes(at_rest, theta)
    J = np.concatenate([J / max(noise, rms), of_rest, known])
    column = np.linalg.norm(J, axis=0)
    covariance = np.linalg.pinv((J / column).T @ (J / column)) / np.outer(column, column)
    covariance = covariance[: len(theta), : len(theta)]
    basis = _basis(s, theta, form)
    difference = _stacked(Y - form.response(s, theta) * U)
    transient = basis @ np.linalg.lstsq(basis, difference, rcond=None)[0]
    half = len(s)
    clean = Y - (transient[:half] + 1j * transient[half:])
    return Fit(
        theta=theta,
        covariance=covariance,
        noise=noise,
        rms=rms,
        cost=float(best.cost),
        pulled=(theta - form.centre) / form.spread,
        frequency=frequency[used],
        measured=clean / U,
        fitted=form.response(s, theta),
    )


def noise_of(record: Record) -> float:
    """
    Return the deviation of white noise of the output, from the frequencies that no motion reaches.

    A window keeps what is not over at the ends of the record out of them.
    """
    n = len(record.y)
    window = np.hanning(n)
    spectrum = np.abs(np.fft.rfft(window * (record.y - np.mean(record.y)))) ** 2
    clear = np.fft.rfftfreq(n, record.period) >= min(CLEAR * record.highest, 0.3 / record.period)
    return float(np.sqrt(np.mean(spectrum[clear]) / np.sum(window**2)))


def _stacked(values: Complexes) -> Floats:
    return np.concatenate([values.real, values.imag])


def _basis(s: Complexes, theta: Floats, form: Form) -> Floats:
    """Columns of the transient, in powers of s up to the band's end."""
    share = s / np.abs(s[-1])
    denominator = form.denominator(s, theta)
    denominator = denominator / np.abs(denominator[0])
    return np.column_stack([_stacked(share**i / denominator) for i in range(form.n_transient)])


def _slopes(function: Callable[[Floats], Floats], theta: Floats) -> Floats:
    steps = STEP * np.maximum(np.abs(theta), 1e-3)
    return np.column_stack(
        [
            (function(theta + e) - function(theta - e)) / (2.0 * h)
            for e, h in zip(np.diag(steps), steps, strict=True)
        ]
    )

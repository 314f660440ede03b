"""
What a channel cannot tell apart: its noise floor, without a model, and what colour the noise has.

| evidence | floor |
|---|---|
| repetition | the spread between settled repetitions of the same motion, over sqrt(2) |
| rest | the spread about a line where nothing that drives the channel moves |
| differences | d = (1, -4, 6, -4, 1)/sqrt(70) over the samples, from the median of abs(d) |
| converter | the step q of the channel's numbers over sqrt(12), never less than this |

The first that there is counts. Periods of one recording are compared about a line, since what integrates
comes back to another place; of repetitions the later half counts, which has settled. Where it has not, or
where a channel rings at rest, the spread is many times that of differences, and does not count. Differences
are biased upwards by motion above some tenth of the sampling rate, and downwards by coloured noise.

Source: Hall, Kay, Titterington, Biometrika 77 (1990) 521 (differences); Widrow, Kollar, Quantization Noise
(2008), Ch. 4 (converter); Pintelon, Schoukens, System Identification (2012), Ch. 4 (repetition).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from enum import Enum

import numpy as np
import scipy  # loads its packages when they are used

from .arrays import TINY, Array

DIFFERENCES = np.array([1.0, -4.0, 6.0, -4.0, 1.0]) / np.sqrt(70.0)
NORMAL_MEDIAN = 0.6744897501960817  # of the absolute value of a standard normal number
SQRT_12 = float(np.sqrt(12.0))
LEAST_REST = 0.25  # s, of a stretch in which nothing moves
FEWEST_AT_REST = 100  # samples
REST = 1.5  # deviation of a driving signal within a stretch, over its own noise
STILL = 5.0  # floor over that of differences, above which the channel rings at rest, or has not repeated
REPEATED = 2e-3  # rms of the difference of two periods over the rms of the motion
LEAST_PERIODS = 2
FEWEST_PER_PERIOD = 100  # samples
GRID = 1e-3  # of a step: how far samples may be from its multiples
MOST_STEPS = 1 << 20  # over the range of a channel: finer steps are no converter's
LINE = 12.0  # power density of a line over that of its surroundings
FIRST_LINE = 5  # place in the spectrum, below which a slope looks like a line
LINE_SHARE = 0.01  # of the power, below which a line is not named
SLOPE_OF_PINK = -0.5  # of log power density over log frequency, from which on noise is coloured
SPIKE = 6.0  # robust deviations
SEGMENTS = 16  # of the record, for a spectrum


class Evidence(Enum):
    """Where a floor comes from, the strongest first."""

    REPETITION = "repetition"
    REST = "rest"
    DIFFERENCES = "differences"
    CONVERTER = "converter"
    ROUNDING = "exact digits"


@dataclass(frozen=True)
class NoiseFloor:
    """
    Standard deviation that a channel cannot fall below, in its unit, and the evidence for it.

    `step` is the step of the channel's numbers, 0 where they have none.
    """

    value: float
    evidence: Evidence
    step: float = 0.0


@dataclass(frozen=True)
class Colour:
    """
    How a residual is spread over frequency and time.

    `slope` is that of the logarithm of the power density over that of the frequency, `lines` the frequencies
    [Hz] of lines, `spikes` the number of samples beyond six robust deviations.
    """

    slope: float
    lines: tuple[float, ...]
    spikes: int

    @property
    def words(self) -> str:
        """The colour for people."""
        kind = "coloured, strongest at low frequencies" if self.slope < SLOPE_OF_PINK else "white"
        found = [kind, *(f"a line at {f:.4g} Hz" for f in self.lines)]
        if self.spikes:
            found.append(f"{self.spikes} spikes")
        return ", ".join(found)


def noise_floor(values: Sequence[Array], driving: Sequence[Array], period: float) -> NoiseFloor:
    """
    Estimate the floor of a channel.

    Args:
        values: The channel in each recording, shape (samples,).
        driving: What drives it in each recording, shape (samples, signals).
        period: Of the samples [s].
    """
    step = step_of(np.concatenate(values))
    least = step / SQRT_12
    differences = float(np.median([from_differences(v) for v in values]))
    most = STILL * max(differences, least)
    repeated = _from_repetition(values, driving)
    if repeated is not None and repeated < most:
        return _limited(repeated, Evidence.REPETITION, least, step)
    rest = _from_rest(values, driving, period)
    if rest is not None and rest < most:
        return _limited(rest, Evidence.REST, least, step)
    return _limited(differences, Evidence.DIFFERENCES, least, step)


def from_differences(values: Array) -> float:
    """Standard deviation of white noise on a smooth signal (samples,), from fourth differences."""
    d = np.abs(np.convolve(values, DIFFERENCES, "valid"))
    return float(np.median(d) / NORMAL_MEDIAN) if len(d) else 0.0


def step_of(values: Array) -> float:
    """Step of which all values are multiples apart; 0 if there is none that a converter could have."""
    levels = np.unique(values[np.isfinite(values)])
    if len(levels) < 3:
        return 0.0
    apart = np.diff(levels)
    span = float(levels[-1] - levels[0])
    apart = apart[apart > 1e-9 * span]
    if not len(apart):
        return 0.0
    step = float(apart.min())
    if span > MOST_STEPS * step:
        return 0.0
    multiples = apart / step
    step = float(apart.sum() / np.round(multiples).sum())
    off = np.abs(apart / step - np.round(apart / step))
    return step if bool(np.all(off < np.maximum(GRID * np.round(apart / step), 10.0 * GRID))) else 0.0


def colour_of(residual: Array, period: float) -> Colour:
    """Spread of a residual (samples,) over frequency and time."""
    n = max(64, len(residual) // SEGMENTS)
    frequency, density = scipy.signal.welch(residual, 1.0 / period, nperseg=min(n, len(residual)))
    frequency = frequency[1:]
    density = np.maximum(density[1:], TINY)
    around = scipy.signal.medfilt(density, min(31, 2 * (len(density) // 4) + 1))
    is_line = density > LINE * np.maximum(around, TINY)
    total = float(density.sum())
    lines = []
    for run in np.split(np.flatnonzero(is_line), np.flatnonzero(np.diff(np.flatnonzero(is_line)) > 1) + 1):
        if len(run) and run[0] >= FIRST_LINE and float(density[run].sum()) > LINE_SHARE * total:
            lines.append(float(frequency[run[np.argmax(density[run])]]))
    use = ~is_line
    slope = float(np.polyfit(np.log(frequency[use]), np.log(density[use]), 1)[0]) if use.sum() > 2 else 0.0
    robust = float(np.median(np.abs(residual - np.median(residual)))) / NORMAL_MEDIAN
    spikes = int(np.sum(np.abs(residual) > SPIKE * robust)) if robust > 0.0 else 0
    return Colour(slope, tuple(lines), spikes)


def _limited(value: float, evidence: Evidence, least: float, step: float) -> NoiseFloor:
    return NoiseFloor(value, evidence, step) if value > least else NoiseFloor(least, Evidence.CONVERTER, step)


def _from_rest(values: Sequence[Array], driving: Sequence[Array], period: float) -> float | None:
    """Pooled deviation about a line over all stretches in which nothing moves."""
    n = max(FEWEST_AT_REST, round(LEAST_REST / period))
    squares = []
    for own, inputs in zip(values, driving, strict=True):
        if not inputs.shape[1]:
            continue
        noise = np.array([from_differences(column) for column in inputs.T])
        for begin in range(0, len(own) - n + 1, n):
            rows = slice(begin, begin + n)
            if np.all(inputs[rows].std(axis=0) <= REST * noise):
                squares.append(float(_about_line(own[rows, None])[0] ** 2))
    return float(np.sqrt(np.median(squares))) if squares else None  # some ring down after a motion


def _about_line(values: Array) -> Array:
    """Deviation of signals (samples, m) about a line, shape (m,)."""
    return np.asarray(
        scipy.signal.detrend(values, axis=0).std(axis=0) * np.sqrt(len(values) / (len(values) - 2.0))
    )


def _from_repetition(values: Sequence[Array], driving: Sequence[Array]) -> float | None:
    """Spread between periods of a motion that repeats, or between recordings that repeat it."""
    squares = []
    for own, inputs in zip(values, driving, strict=True):
        lag = _period_of(inputs)
        if lag is not None:
            settled = _settled(own[lag:] - own[:-lag])
            squares.append(float(_about_line(settled[:, None])[0] ** 2) / 2.0)
    for i, one in enumerate(driving):
        for j in range(i):
            other = driving[j]
            if one.shape == other.shape and _is_same(one, other):
                squares.append(float(np.mean(_settled(values[i] - values[j]) ** 2)) / 2.0)
    return float(np.sqrt(np.mean(squares))) if squares else None


def _settled(apart: Array) -> Array:
    """The later half of a difference between repetitions: by then what began otherwise has died out."""
    return apart[len(apart) // 2 :]


def _period_of(inputs: Array) -> int | None:
    """Lag [samples] after which all driving signals (samples, m) repeat."""
    moving = inputs[:, inputs.std(axis=0) > 0.0]
    n = len(moving)
    if not moving.shape[1] or n < LEAST_PERIODS * FEWEST_PER_PERIOD:
        return None
    first = moving[:, 0] - moving[:, 0].mean()
    spectrum = np.abs(np.fft.rfft(first, 2 * n)) ** 2
    overlap = np.arange(n, 0, -1)
    correlation = np.fft.irfft(spectrum)[:n] / overlap
    search = correlation[FEWEST_PER_PERIOD : n // LEAST_PERIODS + 1]
    if not len(search):
        return None
    lag = FEWEST_PER_PERIOD + int(np.argmax(search))
    return lag if _is_same(moving[lag:], moving[:-lag]) else None


def _is_same(one: Array, other: Array) -> bool:
    spread = one.std(axis=0)
    used = spread > 0.0
    apart = np.sqrt(np.mean((one - other) ** 2, axis=0))
    return bool(used.any() and np.all(apart[used] <= REPEATED * spread[used]) and not np.any(apart[~used]))

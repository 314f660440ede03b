"""Confidence intervals of probabilities and means, from counts and sums that grow run by run."""

from __future__ import annotations

import math
from dataclasses import dataclass

from scipy import special


@dataclass(frozen=True)
class Interval:
    """An estimate with its confidence interval, of `n` runs."""

    value: float
    low: float
    high: float
    n: int

    @property
    def half_width(self) -> float:
        """Half of its width."""
        return 0.5 * (self.high - self.low)


def quantile_of_normal(confidence: float) -> float:
    """Return z for which a normal variable is within +-z deviations with this probability."""
    return float(special.ndtri(0.5 + 0.5 * confidence))


def probability(hits: int, n: int, confidence: float = 0.95) -> Interval:
    """
    Estimate a probability from hits in n independent runs, n > 0.

    Source: Wilson, Probable inference, the law of succession, and statistical inference, JASA 22 (1927).
    """
    z = quantile_of_normal(confidence)
    share = hits / n
    middle = (share + z * z / (2 * n)) / (1 + z * z / n)
    half = z / (1 + z * z / n) * math.sqrt(share * (1 - share) / n + z * z / (4 * n * n))
    return Interval(share, max(0.0, min(share, middle - half)), min(1.0, max(share, middle + half)), n)


class Running:
    """
    Mean and interval of a measure while runs come in; what has no number is left out.

    Source: Welford, Note on a method for calculating corrected sums of squares, Technometrics 4 (1962).
    """

    def __init__(self, *, is_share: bool, confidence: float = 0.95) -> None:
        self.n = 0
        self._mean = 0.0
        self._squares = 0.0
        self._is_share = is_share
        self._confidence = confidence

    def add(self, value: float | None) -> None:
        """Take the number of one more run."""
        if value is None or not math.isfinite(value):
            return
        self.n += 1
        before = value - self._mean
        self._mean += before / self.n
        self._squares += before * (value - self._mean)

    def interval(self) -> Interval | None:
        """Return the interval; None of fewer than two runs."""
        if self.n < 2:
            return None
        if self._is_share:
            return probability(round(self._mean * self.n), self.n, self._confidence)
        deviation = math.sqrt(self._squares / (self.n - 1))
        half = quantile_of_normal(self._confidence) * deviation / math.sqrt(self.n)
        return Interval(self._mean, self._mean - half, self._mean + half, self.n)

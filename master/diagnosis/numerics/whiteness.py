"""
Tests on a residual: is there anything left that depends on the signals?

Whiteness (Ljung-Box) is reported and decides nothing: the residual of an output-error fit is coloured
without any missing effect. What decides is the cross-correlation of the whitened residual with signals that
went through the same filter, with the family-wise error of all bases and lags kept at alpha (Holm).

Sources: Box, Jenkins, Reinsel, Time Series Analysis (2008), Sec. 12.1 (prewhitening); Billings, Zhu, Int.
J. Control 60 (1994) 1107 (non-linear correlation tests); Holm, Scand. J. Stat. 6 (1979) 65; Ljung, Box,
Biometrika 65 (1978) 297; Politis, Romano, J. Am. Stat. Assoc. 89 (1994) 1303 (bootstrap in blocks).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import scipy  # loads its packages when they are used

from .arrays import Array

ORDER = 20  # of the whitening filter
LAGS = 25  # samples
ALPHA = 0.01  # family-wise error
SMALL_CORRELATION = 0.05  # autocorrelation that no longer counts
BLOCKS_PER_CORRELATION = 10  # length of a bootstrap's block over the correlation's


class Interval(NamedTuple):
    """Lower and upper end of a confidence interval."""

    low: float
    high: float


@dataclass(frozen=True)
class Correlation:
    """Strongest correlation of the residual with one basis; `p` is corrected for all bases and lags."""

    basis: str
    lag: int
    value: float
    p: float
    is_found: bool


def whitening(residual: Array, order: int = ORDER) -> Array:
    """Coefficients 1, -a_1, ... of the autoregressive filter that whitens a residual, shape (order + 1,)."""
    r = residual - residual.mean()
    n = len(r)
    covariance = np.array([r[: n - k] @ r[k:] for k in range(order + 1)]) / n
    if covariance[0] <= 0.0:
        return np.concatenate([[1.0], np.zeros(order)])
    covariance[0] *= 1.0 + 1e-9
    return np.concatenate([[1.0], -scipy.linalg.solve_toeplitz(covariance[:-1], covariance[1:])])


def filtered(values: Array, coefficients: Array) -> Array:
    """Pass values, less their mean, through a whitening filter; rows while it fills are left out."""
    whole = scipy.signal.lfilter(coefficients, [1.0], values - values.mean())
    return np.asarray(whole[len(coefficients) - 1 :])


def cross_correlations(
    residual: Array,
    bases: Mapping[str, Array],
    *,
    linear: Mapping[str, Array] | None = None,
    lags: int = LAGS,
    alpha: float = ALPHA,
) -> list[Correlation]:
    """
    Test a residual against bases at lags 0..lags (a basis leads), strongest first.

    Args:
        residual: Shape (n,).
        bases: What it may depend on, for example x^2, abs(v) v; shape (n,) each.
        linear: Signals whose linear share, at lag 0 and 1, is taken out of the bases first.
        lags: Largest lag in samples.
        alpha: Family-wise error over all bases and lags.
    """
    a = whitening(residual)
    e = _standard(filtered(residual, a))
    taken = _spanned([filtered(v, a) for v in (linear or {}).values()], len(e))
    strengths: list[tuple[str, int, float]] = []
    for name, values in bases.items():
        x = filtered(values, a)
        x = _standard(x - taken @ (taken.T @ x))
        n = len(e)
        r = np.array([e[lag:] @ x[: n - lag] for lag in range(lags + 1)]) / n
        strengths += [(name, lag, float(value)) for lag, value in enumerate(r)]
    p = 2.0 * scipy.stats.norm.sf(np.abs([value for *_, value in strengths]) * np.sqrt(len(e)))
    corrected = holm(np.asarray(p))
    best: dict[str, Correlation] = {}
    for (name, lag, value), p_value in zip(strengths, corrected, strict=True):
        if name not in best or abs(value) > abs(best[name].value):
            best[name] = Correlation(name, lag, value, float(p_value), bool(p_value < alpha))
    return sorted(best.values(), key=lambda c: -abs(c.value))


def holm(p: Array) -> Array:
    """Correct p-values so that the chance of any false one is kept, shape of p."""
    order = np.argsort(p)
    n = len(p)
    stepped = np.maximum.accumulate(p[order] * (n - np.arange(n)))
    corrected = np.empty(n)
    corrected[order] = np.minimum(stepped, 1.0)
    return corrected


def ljung_box(residual: Array, lags: int = LAGS) -> float:
    """Return the p-value of whiteness over lags 1..lags; a report, not a decision."""
    e = _standard(residual)
    n = len(residual)
    r = np.array([e[lag:] @ e[: n - lag] for lag in range(1, lags + 1)]) / n
    q = n * (n + 2) * float(np.sum(r * r / (n - np.arange(1, lags + 1))))
    return float(scipy.stats.chi2.sf(q, lags))


def block_bootstrap(
    statistic: Callable[..., float],
    *series: Array,
    block: int,
    n_draws: int = 1000,
    seed: int = 1,
    level: float = 0.95,
) -> Interval:
    """
    Interval of a statistic of dependent samples.

    Args:
        statistic: Function of as many arrays as series.
        series: Samples of the same times, shape (n,) each; rows are drawn together, in circular blocks.
        block: Length of a block in samples, longer than the correlation.
        n_draws: Number of draws.
        seed: Of the draws.
        level: Coverage.
    """
    n = len(series[0])
    rng = np.random.default_rng(seed)
    block = min(block, n)
    count = -(-n // block)
    values = []
    for _ in range(n_draws):
        starts = rng.integers(0, n, count)
        rows = ((starts[:, None] + np.arange(block)) % n).ravel()[:n]
        values.append(statistic(*(s[rows] for s in series)))
    low, high = np.quantile(values, [(1.0 - level) / 2.0, (1.0 + level) / 2.0])
    return Interval(float(low), float(high))


def correlation_length(values: Array, fewest: int = 10) -> int:
    """Ten times the first lag at which the autocorrelation is below 1/e [samples]: a length for blocks."""
    e = _standard(values)
    n = len(values)
    r = np.fft.irfft(np.abs(np.fft.rfft(e, 2 * n)) ** 2)[:n] / n
    below = np.flatnonzero(r < np.exp(-1.0))
    return int(max(fewest, BLOCKS_PER_CORRELATION * below[0])) if len(below) else n


def variance_inflation(residual: Array, longest: int = 200) -> float:
    """Variance of the mean of a coloured residual (n,) over that of a white one; lags up to `longest`."""
    e = residual - residual.mean()
    n = len(e)
    power = float(e @ e) or 1.0
    total = 1.0
    for lag in range(1, min(longest, n // 4)):
        r = float(e[lag:] @ e[: n - lag]) / power
        if r < SMALL_CORRELATION:
            break
        total += 2.0 * r
    return total


def _spanned(signals: list[Array], n: int) -> Array:
    """Orthonormal columns that span signals (n,) at lag 0 and 1, shape (n, rank)."""
    if not signals:
        return np.zeros((n, 0))
    matrix = np.column_stack([column for s in signals for column in (s, np.roll(s, 1))])
    left, sizes, _ = np.linalg.svd(matrix, full_matrices=False)
    return np.asarray(left[:, sizes > np.finfo(float).eps * n * sizes[0]])


def _standard(values: Array) -> Array:
    centred = values - values.mean()
    size = centred.std()
    return np.asarray(centred / size if size > 0.0 else centred)

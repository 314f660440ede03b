"""
Regressions that know no physics, each judged on rows that it has not seen.

| regression | finds |
|---|---|
| ridge over columns | linear dynamics; smooth laws, as splines passed through a response |
| boosted trees | steps, thresholds, codes, laws with memory of what their columns remember |
| a line of z(t) e(t) | a law whose factor oscillates in time |
| a line over a signal | steps of a converter, a force that repeats with the position |

Source: Hastie, Tibshirani, Friedman, The Elements of Statistical Learning (2009), Secs. 3.4, 10.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from sklearn.ensemble import HistGradientBoostingRegressor
from threadpoolctl import threadpool_limits

from .arrays import TINY, Array, Integers, Mask
from .folds import Fold, Folds

RIDGES = np.logspace(-6, 2, 9)  # over the number of rows, for columns of deviation 1
MOST_ROWS = 16000  # that a regression uses
LEAST_VARIANCE = 1e-12  # of a column on the rows that are fitted on, over that on all
N_TREES = 60
LEAVES = 15
FEWEST_IN_LEAF = 60
BINS_OF_TREES = 63  # over a signal: about as many rows in each as a leaf needs
RATE = 0.2  # of the boosting
MOST_ROWS_OF_TREES = 2500
PADDING = 4  # of a spectrum: its lines are this much finer than the time allows
SAME_LINE = 0.5  # over the time: largest difference of frequencies that are one
N_REFINED = 21  # frequencies around a line
FEWEST_ROWS_OF_LINES = 1500  # on which these are compared
EVERY_OF_LINES = 5  # row at most: a line of the highest frequency still has three of them a period
LEAST_CYCLES = 1.0  # over the recordings
LEAST_CYCLES_ALONE = 20.0  # of a line by itself: below, it is a wave of coloured noise
N_HARMONICS = 3
BINS = 4096  # over the range of a signal
MAINS = (50.0, 60.0)  # Hz: a line there, or at a multiple, is hum
HUM = 0.01  # relative distance from it


@dataclass(frozen=True)
class HeldOut:
    """Held-out prediction, shape (rows,), NaN outside the blocks; `frequency` of a line, in its unit."""

    explained: Array
    frequency: float = 0.0


def ridge(residual: Array, columns: Array, folds: Folds) -> HeldOut:
    """
    Ridge regression on columns; the penalty is chosen inside what is fitted on.

    Args:
        residual: Shape (rows,).
        columns: Shape (rows, m).
        folds: Blocks of rows.
    """
    explained = np.full(len(residual), np.nan)
    sums = _Sums(residual, columns, folds)
    for i, fold in enumerate(folds):
        inner = _Ridge(sums.of_inner(i))
        tried = inner.predict(sums.standard[fold.inner_held_out], RIDGES.tolist())
        wanted = residual[fold.inner_held_out]
        best = int(np.argmin(np.sum((wanted[:, None] - tried) ** 2, axis=0)))
        model = _Ridge(sums.of_fitted(i))
        predicted = model.predict(sums.standard[fold.held_out], [RIDGES[best]])[:, 0]
        explained[fold.held_out] = _trust(wanted, tried[:, best]) * predicted
    return HeldOut(explained)


def trees(residual: Array, columns: Array, folds: Folds) -> HeldOut:
    """Gradient-boosted trees on columns, shape (rows, m)."""
    explained = np.full(len(residual), np.nan)
    with threadpool_limits(limits=1):  # the data are small: threads would only wait for each other
        for fold in folds:
            explained[fold.held_out] = _grown(residual, columns, fold.fitted).predict(columns[fold.held_out])
    return HeldOut(explained)


def _grown(residual: Array, columns: Array, rows: Integers) -> HistGradientBoostingRegressor:
    kept = _thinned(rows, MOST_ROWS_OF_TREES)
    model = HistGradientBoostingRegressor(
        max_iter=N_TREES,
        max_leaf_nodes=LEAVES,
        min_samples_leaf=min(FEWEST_IN_LEAF, max(5, len(kept) // 20)),
        learning_rate=RATE,
        max_bins=BINS_OF_TREES,
        early_stopping=False,
        random_state=0,
    )
    return model.fit(columns[kept], residual[kept])


def line(residual: Array, factor: Array, t: Array, folds: Folds, *, highest: float) -> HeldOut:
    """
    The strongest line of the residual times a factor, with two quadratures.

    Args:
        residual: Shape (rows,).
        factor: z, shape (rows,): 1, or a signal that may be modulated.
        t: Time of the rows [s], evenly spaced within a recording.
        folds: Blocks of rows.
        highest: Frequency above which no line is sought [Hz].
    """
    explained = np.full(len(residual), np.nan)
    period = float(np.median(np.abs(np.diff(t)))) or 1.0
    is_plain = bool(np.ptp(factor) == 0.0)
    index = np.round((t - t.min()) / period).astype(np.int64)
    found = []
    for fold in folds:
        product = np.zeros(len(residual))
        product[fold.fitted] = (residual * factor)[fold.fitted]
        over_time = np.asarray(np.bincount(index, product), dtype=np.float64)
        frequency = _peak(over_time, period, highest, is_plain=is_plain)
        if frequency <= 0.0:
            explained[fold.held_out] = 0.0
            continue
        duration = period * len(over_time)
        near = frequency + np.linspace(-0.5, 0.5, N_REFINED) / (PADDING * duration)
        rows = _some(fold.fitted)
        z, at, left = factor[rows], t[rows], residual[rows]
        frequency = min(near, key=lambda f: _left(left, _modulated(z, at, f)))
        found.append(frequency)
        explained[fold.held_out] = _solved(residual, _modulated(factor, t, frequency), fold)
    is_one = bool(found) and np.ptp(found) < SAME_LINE / (period * (1 + int(index.max())))
    if not (is_one and _holds_throughout(residual, explained, folds)):
        explained[folds.rows] = 0.0  # a law has one frequency, whatever it is found on, and does not end
    return HeldOut(explained, float(np.median(found)) if found else 0.0)


def _holds_throughout(residual: Array, explained: Array, folds: Folds) -> bool:
    """Whether a prediction makes no group of blocks that was held out worse."""
    return all(
        np.sum((residual - explained)[fold.held_out] ** 2) <= np.sum(residual[fold.held_out] ** 2)
        for fold in folds
    )


def without_mains(residual: Array, t: Array, rows: Integers, *, highest: float) -> Array:
    """
    Take the lines of the mains, and of their multiples, out of a residual.

    Times a signal that moves slowly, hum is a line near that of the mains: it would pass for a law whose
    factor oscillates.

    Args:
        residual: Shape (rows,).
        t: Time of the rows [s], evenly spaced within a recording.
        rows: Those that are used.
        highest: Frequency above which a line does not matter [Hz].
    """
    period = float(np.median(np.abs(np.diff(t)))) or 1.0
    index = np.round((t[rows] - t.min()) / period).astype(np.int64)
    left = residual.astype(np.float64)
    over_time = np.asarray(np.bincount(index, left[rows]), dtype=np.float64)
    n = PADDING * len(over_time)
    power = np.abs(np.fft.rfft(over_time, n)) ** 2
    frequency = np.fft.rfftfreq(n, period)
    ones = np.ones(len(residual))
    some = _some(rows)
    for mains in MAINS:
        for multiple in np.arange(mains, (1.0 + HUM) * highest, mains):
            close = np.flatnonzero(np.abs(frequency - multiple) < HUM * mains)
            if not len(close):
                continue
            peak = float(frequency[close[np.argmax(power[close])]])
            near = peak + np.linspace(-0.5, 0.5, N_REFINED) * float(frequency[1])
            columns = _modulated(ones, t, _strongest(left[some], t[some], near))
            left -= columns @ np.linalg.lstsq(columns[rows], left[rows], rcond=None)[0]
    return left


def line_over(residual: Array, values: Array, folds: Folds) -> HeldOut:
    """The strongest line of the residual over a signal (rows,) instead of over time, with its harmonics."""
    explained = np.full(len(residual), np.nan)
    span = float(np.ptp(values))
    if span == 0.0:
        return HeldOut(np.zeros(len(residual)))
    width = span / BINS
    index = ((values - values.min()) / width).astype(np.int64)
    found = []
    for fold in folds:
        rows = fold.fitted
        over = np.bincount(index[rows], residual[rows] - residual[rows].mean(), minlength=BINS + 1)
        power = np.abs(np.fft.rfft(over, PADDING * len(over))) ** 2
        frequency = np.fft.rfftfreq(PADDING * len(over), width)
        power[frequency < 2.0 / span] = 0.0
        best = float(frequency[int(np.argmax(power))])
        near = best + np.linspace(-0.5, 0.5, N_REFINED) * float(frequency[1])
        rows = _some(rows)
        own, left = values[rows], residual[rows]
        best = min(near, key=lambda f: _left(left, _waves(own, f)))
        found.append(best)
        explained[fold.held_out] = _solved(residual, _waves(values, best), fold)
    return HeldOut(explained, float(np.median(found)))


class _Sums:
    """
    Sums of products of 1, the columns and the residual, over rows that the folds treat alike.

    Each row is multiplied once; what a fold is fitted on are sums of these sums. `standard` are the columns
    over all rows, less their mean and over their deviation.
    """

    def __init__(self, residual: Array, columns: Array, folds: Folds) -> None:
        rows = folds.rows
        deviation = columns[rows].std(axis=0)
        self.standard = (columns - columns[rows].mean(axis=0)) / np.where(deviation > 0.0, deviation, 1.0)
        used = np.zeros(len(residual), dtype=bool)
        used[_thinned(rows, MOST_ROWS)] = True
        kind = np.zeros(len(residual), dtype=np.int64)
        for i, fold in enumerate(folds):
            kind[fold.fitted] |= 1 << 2 * i
            kind[fold.inner_fitted] |= 2 << 2 * i
        self.kinds = np.unique(kind[used])
        self.products = [self._products(residual, used & (kind == own)) for own in self.kinds]

    def _products(self, residual: Array, rows: Mask) -> Array:
        own = self.standard[rows]
        whole = np.column_stack([np.ones(len(own)), own, residual[rows]])
        return np.asarray(whole.T @ whole)

    def of_fitted(self, i: int) -> Array:
        """Sums over the rows that the fold i is fitted on, shape (columns + 2,) squared."""
        return self._sum(1 << 2 * i)

    def of_inner(self, i: int) -> Array:
        """Sums over the rows that it is fitted on while its penalty is chosen."""
        return self._sum(2 << 2 * i)

    def _sum(self, bit: int) -> Array:
        size = self.standard.shape[1] + 2
        own = (p for kind, p in zip(self.kinds, self.products, strict=True) if kind & bit)
        return sum(own, start=np.zeros((size, size)))


class _Ridge:
    """Normal equations of standardised columns from sums of products, decomposed once for all penalties."""

    def __init__(self, sums: Array) -> None:
        self.n = max(float(sums[0, 0]), 1.0)
        self.mean = sums[0, 1:-1] / self.n
        self.offset = float(sums[0, -1]) / self.n
        normal = sums[1:-1, 1:-1] - self.n * np.outer(self.mean, self.mean)
        target = sums[1:-1, -1] - self.n * self.mean * self.offset
        variance = np.diag(normal) / self.n
        moves = variance > LEAST_VARIANCE  # a spline may rest wherever it is fitted
        self.over_scale = np.where(moves, 1.0 / np.sqrt(np.where(moves, variance, 1.0)), 0.0)
        values, self.vectors = np.linalg.eigh(normal * np.outer(self.over_scale, self.over_scale))
        self.values = np.maximum(values, 0.0)
        self.target = self.vectors.T @ (target * self.over_scale)

    def predict(self, columns: Array, penalties: Sequence[float]) -> Array:
        """Predictions for several penalties, shape (rows, penalties)."""
        weights = self.target[:, None] / (self.values[:, None] + self.n * np.asarray(penalties)[None, :])
        factors = self.over_scale[:, None] * (self.vectors @ weights)
        return np.asarray(self.offset + columns @ factors - self.mean @ factors)


def _trust(residual: Array, predicted: Array) -> float:
    """Slope of a residual over what was predicted of it on rows that were not seen, within 0 and 1."""
    power = float(predicted @ predicted)
    return float(np.clip(residual @ predicted / power, 0.0, 1.0)) if power > 0.0 else 0.0


def _thinned(rows: Integers, most: int) -> Integers:
    return rows[:: max(1, -(-len(rows) // most))]


def _some(rows: Integers) -> Integers:
    return _thinned(rows, max(FEWEST_ROWS_OF_LINES, -(-len(rows) // EVERY_OF_LINES)))


def _peak(product: Array, period: float, highest: float, *, is_plain: bool) -> float:
    """Frequency of the strongest line [Hz], 0 if there is none to look for."""
    n = PADDING * len(product)
    power = np.abs(np.fft.rfft(product, n)) ** 2
    frequency = np.fft.rfftfreq(n, period)
    least = LEAST_CYCLES_ALONE if is_plain else LEAST_CYCLES
    power[(frequency < least / (period * len(product))) | (frequency > highest)] = 0.0
    if is_plain:
        for mains in MAINS:
            order = np.round(frequency / mains)
            power[(order > 0.0) & (np.abs(frequency - order * mains) < HUM * mains)] = 0.0
    best = int(np.argmax(power))
    return float(frequency[best]) if power[best] > 0.0 else 0.0


def _strongest(residual: Array, t: Array, frequencies: Array) -> float:
    """The frequency of the line that takes most of a residual."""
    ones = np.ones(len(t))
    return float(min(frequencies, key=lambda f: _left(residual, _modulated(ones, t, f))))


def _modulated(factor: Array, t: Array, frequency: float) -> Array:
    angle = 2.0 * np.pi * frequency * t
    return np.column_stack([factor * np.sin(angle), factor * np.cos(angle)])


def _waves(values: Array, frequency: float) -> Array:
    angles = [2.0 * np.pi * n * frequency * values for n in range(1, N_HARMONICS + 1)]
    return np.column_stack([f(angle) for angle in angles for f in (np.sin, np.cos)])


def _solved(residual: Array, columns: Array, fold: Fold) -> Array:
    """Prediction of the rows that are held out, as far as one of the inner rows holds."""
    inner = np.linalg.lstsq(columns[fold.inner_fitted], residual[fold.inner_fitted], rcond=None)[0]
    trust = _trust(residual[fold.inner_held_out], columns[fold.inner_held_out] @ inner)
    weights = np.linalg.lstsq(columns[fold.fitted], residual[fold.fitted], rcond=None)[0]
    return np.asarray(trust * (columns[fold.held_out] @ weights))


def _left(residual: Array, a: Array) -> float:
    """Power that columns leave of a residual, less its own."""
    normal = a.T @ a
    target = a.T @ residual
    normal[np.diag_indices_from(normal)] += TINY + 1e-12 * float(np.trace(normal))
    return float(-target @ np.linalg.solve(normal, target))

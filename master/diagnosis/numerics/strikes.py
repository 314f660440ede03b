"""
Few stretches of time that hold most of a residual's power, or that set off what rings on after them.

What strikes a lightly damped system rings on for long, and its power is then spread over all times. The part
that the residual's own past does not predict (innovations of an autoregressive model) is of strikes alone.

Source: Box, Jenkins, Time Series Analysis (1976), Ch. 7 (innovations); Huber, Robust Statistics (1981), Ch. 7
(weights, so that strikes do not decide about the model that predicts between them).
"""

from __future__ import annotations

import numpy as np

from .arrays import TINY, Array, Integers, Mask

FEWEST = 8  # windows, to call any of them few
EVENT = 4.0  # rms of a window over the median of all, of an event
FEW = 0.15  # of the time
MOST = 0.5  # of the power
ORDER = 8  # of the autoregressive model
PASSES = 10  # with weights
LARGE = 1.345  # deviations from which on a value weighs less
MEDIAN_OF_NORMAL = 0.6745  # of the size of a normal value, in deviations


def few_hold_most(powers: Array) -> Mask:
    """Windows, of those with these powers (windows,), that hold most of it if they are few; none if not."""
    none = np.zeros(len(powers), dtype=bool)
    if len(powers) < FEWEST:
        return none
    is_event = powers > EVENT**2 * max(float(np.median(powers)), TINY)
    is_rare = 0.0 < is_event.mean() < FEW
    return is_event if is_rare and powers[is_event].sum() >= MOST * powers.sum() else none


def windows(rows: Mask, length: int) -> Integers:
    """First rows of windows of `length` rows one after the other, each wholly inside the rows in use (n,)."""
    used = np.flatnonzero(rows)
    starts = [
        k for k in range(0, len(used) - length + 1, length) if used[k + length - 1] - used[k] == length - 1
    ]
    return used[np.asarray(starts, dtype=np.int64)]


def events(left: Array, rows: Mask, length: int) -> Integers:
    """First rows of the windows of `length` rows that hold most of a residual (n,), if they are few."""
    starts = windows(rows, length)
    powers = np.array([float(np.mean(left[s : s + length] ** 2)) for s in starts])
    return starts[few_hold_most(powers)]


def strikes(left: Array, rows: Mask, length: int, every: int) -> Integers:
    """
    First rows of the windows in which a residual is set off, if they are few.

    Args:
        left: The residual, shape (n,).
        rows: Rows in use, shape (n,).
        length: Rows of a window.
        every: Rows that are averaged first, against noise.
    """
    starts = windows(rows, every)
    if len(starts) < 4 * ORDER:
        return starts[:0]
    means = np.array([float(np.mean(left[s : s + every])) for s in starts])
    follows = np.array([starts[k] - starts[k - ORDER] == ORDER * every for k in range(ORDER, len(starts))])
    past = np.column_stack([means[ORDER - lag : len(means) - lag] for lag in range(1, ORDER + 1)])
    own = np.zeros_like(means)
    own[ORDER:][follows] = _unpredicted(past[follows], means[ORDER:][follows])
    spread = np.zeros(len(left))
    known = np.zeros(len(left), dtype=bool)
    for start, value, is_known in zip(starts, own, [*([False] * ORDER), *follows], strict=True):
        spread[start : start + every] = value
        known[start : start + every] = is_known
    return events(spread, known, length)


def _unpredicted(past: Array, now: Array) -> Array:
    """What a linear model of the past (n, order) does not predict of the present (n,), shape (n,)."""
    weights = np.ones(len(now))
    rest = now
    for _ in range(PASSES):
        root = np.sqrt(weights)
        factors = np.linalg.lstsq(past * root[:, None], now * root, rcond=1e-10)[0]
        rest = now - past @ factors
        deviation = float(np.median(np.abs(rest))) / MEDIAN_OF_NORMAL
        weights = np.minimum(1.0, LARGE * max(deviation, TINY) / np.maximum(np.abs(rest), TINY))
    return np.asarray(rest)

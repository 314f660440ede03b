"""
Noise is alike at all times; what a wrong law leaves is not, whatever its colour.

Differences of means of neighbouring rows (Haar's wavelet) are nearly independent even for coloured noise, so
their sizes can be compared between stretches of time at each scale by itself, by an analysis of variance of
their square roots, which are nearly normal.

Source: Percival, Walden, Wavelet Methods for Time Series Analysis (2000), Secs. 8.6, 9.6 (variances by scale,
and whether they are the same at all times); Wickens, Keppel, Design and Analysis (2004), Ch. 3 (F-test).
"""

from __future__ import annotations

import itertools

import numpy as np
import scipy  # loads its packages when they are used

from .arrays import Array, Mask

SCALES = (8, 16, 32, 64)  # rows of a mean
N_STRETCHES = 16  # about
FEWEST = 3  # differences in a stretch, and stretches
NEAR = 2  # rows on either side that a single row is compared with
SPIKE = 4.0  # robust deviations from those: a row that a logger spoilt
MEDIAN_OF_NORMAL = 0.6745  # of the size of a normal value, in deviations


def chance_of_unevenness(residual: Array, rows: Mask) -> float:
    """
    Probability that stationary noise is as uneven in time as a residual.

    Args:
        residual: Shape (n,), evenly spaced; lines of the mains are to be taken out before.
        rows: Rows in use, shape (n,).

    Returns:
        The least p-value of all scales, corrected for their number (Bonferroni); 1 if there are too few rows.
    """
    steady = _without_spikes(residual)
    stretches = _stretches(rows)
    chances = [p for p in (_chance(steady, stretches, scale) for scale in SCALES) if p is not None]
    return min(1.0, len(chances) * min(chances)) if chances else 1.0


def _chance(values: Array, stretches: list[slice], scale: int) -> float | None:
    groups = []
    for stretch in stretches:
        n = (stretch.stop - stretch.start) // (2 * scale)
        if n < FEWEST:
            continue
        means = values[stretch.start : stretch.start + 2 * n * scale].reshape(n, 2, scale).mean(axis=2)
        groups.append(np.sqrt(np.abs(means[:, 1] - means[:, 0])))
    if len(groups) < FEWEST or not np.ptp(np.concatenate(groups)) > 0.0:
        return None
    return float(scipy.stats.f_oneway(*groups).pvalue)


def _stretches(rows: Mask) -> list[slice]:
    """Rows in use, cut at gaps and into about `N_STRETCHES` parts of one length."""
    edges = np.flatnonzero(np.diff(np.concatenate([[0], rows.astype(np.int8), [0]])))
    total = int(rows.sum())
    found = []
    for begin, end in zip(edges[::2].tolist(), edges[1::2].tolist(), strict=True):
        n = max(1, round((end - begin) * N_STRETCHES / total))
        cuts = np.linspace(begin, end, n + 1).astype(int).tolist()
        found += [slice(a, b) for a, b in itertools.pairwise(cuts)]
    return found


def _without_spikes(values: Array) -> Array:
    """Single rows that stand out from their neighbours, replaced by the median of those."""
    around = scipy.ndimage.median_filter(values, 2 * NEAR + 1)
    apart = np.abs(values - around)
    spread = float(np.median(apart)) / MEDIAN_OF_NORMAL
    return np.asarray(np.where(apart > SPIKE * spread, around, values))

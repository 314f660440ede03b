"""Which of several rigs that fit the columns alike fits the numbers: the one that explains most, linearly."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Protocol

import numpy as np
import scipy  # loads its packages when they are used

from master.diagnosis.numerics.arrays import TINY, Array
from master.recording.tables import Table

from .rig_proposals import Proposal

CLEARLY = 0.02  # of the power: less does not change the order
SHARE_OF_RATE = 0.1  # of the sampling rate: low-pass before a signal is differentiated
ORDER = 4


class Rows(Protocol):
    """What the columns of a recording are read from."""

    @property
    def table(self) -> Table:
        """The columns by name."""


def by_data(rigs: Sequence[Proposal], facts: Rows) -> list[Proposal]:
    """Put the rig first that explains clearly more than the first; only where all are linear sums."""
    if len(rigs) < 2 or not all(own.rig.linear for own in rigs):
        return list(rigs)
    columns = facts.table.columns
    if len({len(columns[name]) for own in rigs for name in own.columns.values()}) > 1:
        return list(rigs)
    shares = [_explained(own, columns) for own in rigs]
    best = int(np.argmax(shares))
    if shares[best] < shares[0] + CLEARLY:
        return list(rigs)
    return [rigs[best], *(own for own in rigs if own is not rigs[best])]


def _explained(own: Proposal, columns: Mapping[str, Array]) -> float:
    """Share of the power of what is compared that the rig explains, with parameters above 0 and an offset."""
    signals = {v: np.asarray(columns[own.columns[v]], dtype=float) for v in own.rig.drives}
    low_pass = scipy.signal.butter(ORDER, 2.0 * SHARE_OF_RATE)
    for rate, of in own.rig.rates.items():
        smooth = signals[of] if of in own.rig.rates else scipy.signal.filtfilt(*low_pass, signals[of])
        signals[rate] = np.gradient(smooth)
    regressors = np.column_stack([signals[name] - signals[name].mean() for name in own.rig.linear])
    regressors = regressors / np.maximum(regressors.std(axis=0), TINY)
    left = 0.0
    for variable in own.rig.compared:
        y = np.asarray(columns[own.columns[variable]], dtype=float)
        y = (y - y.mean()) / max(float(y.std()), TINY)
        _, norm = scipy.optimize.nnls(regressors, y)
        left += norm**2 / len(y)
    return 1.0 - left / len(own.rig.compared)

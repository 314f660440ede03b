"""
Loop transfer of an opened connection at many frequencies.

    L(z) = P (z I - M)^-1 N + Q,   M = U T U*   (Schur form, once),   (z I - T) x = U* N from the last row up

so that a frequency costs n^2 operations instead of n^3: a delay line of hundreds of values is no burden.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import schur

from master.analysis.closed_loop.tick_matrix import OpenedLoop

Complexes = NDArray[np.complex128]

_MOST_NUMBERS = 2_000_000
"""Complex numbers held at once: 32 MB."""


class LoopTransfer:
    """From what the target of a connection gets to what its source would send."""

    def __init__(self, opened: OpenedLoop) -> None:
        self._T, basis = schur(opened.M, output="complex")
        self._source = basis.conj().T @ opened.N[:, 0]
        self._reader = (opened.P @ basis)[0]
        self._direct = complex(opened.Q[0, 0])

    def at(self, z: Complexes) -> Complexes:
        """Return L at each of some z, shape (n,)."""
        found: Complexes = np.empty(len(z), dtype=np.complex128)
        at_once = max(1, _MOST_NUMBERS // max(1, len(self._T)))
        for first in range(0, len(z), at_once):
            some = slice(first, first + at_once)
            found[some] = self._some(z[some])
        return found

    def _some(self, z: Complexes) -> Complexes:
        n = len(self._T)
        x = np.zeros((n, len(z)), dtype=np.complex128)
        for i in reversed(range(n)):
            x[i] = (self._source[i] + self._T[i, i + 1 :] @ x[i + 1 :]) / (z - self._T[i, i])
        found: Complexes = self._reader @ x + self._direct
        return found

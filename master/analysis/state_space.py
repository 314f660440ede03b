"""One FMU as a linear system."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class StateSpace:
    """One FMU as a linear system; `misfit` is the largest relative error over the measured rows."""

    A: Floats
    B: Floats
    C: Floats
    D: Floats
    X0: Floats
    misfit: float
    curvature: float = 0.0

    @property
    def order(self) -> int:
        """Number of states."""
        return len(self.A)

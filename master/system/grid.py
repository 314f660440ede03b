"""The time grid of a run."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Grid:
    """The time grid: tick k goes from t0 + k h to t0 + (k+1) h [s]."""

    t0: float
    step_size: float
    n_ticks: int

    def time(self, tick: int) -> float:
        """Start of a tick [s], computed without accumulation."""
        return self.t0 + tick * self.step_size

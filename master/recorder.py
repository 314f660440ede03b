"""Rows of values as they are computed: row k holds the values at t0 + k h, row 0 the initial ones."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from .graph import Port

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Result:
    """Recorded signals of a run: `values` has shape (rows, signals), `time` [s] has shape (rows,)."""

    time: Floats
    names: tuple[str, ...]
    units: tuple[str, ...]
    values: Floats

    def __getitem__(self, name: str) -> Floats:
        """One signal, shape (rows,); KeyError if it was not recorded."""
        try:
            return self.values[:, self.names.index(name)]
        except ValueError:
            raise KeyError(name) from None

    def unit(self, name: str) -> str:
        """Unit of a signal."""
        return self.units[self.names.index(name)]


@dataclass
class Recorder:
    """Collects chunks of rows."""

    ports: Sequence[Port]
    t0: float
    step_size: float
    chunks: list[Floats] = field(default_factory=list)

    def add(self, rows: Floats) -> None:
        """Append rows, shape (n, signals)."""
        self.chunks.append(np.array(rows))

    def result(self) -> Result:
        """All rows so far."""
        values = np.concatenate(self.chunks)
        time = self.t0 + np.arange(len(values), dtype=np.float64) * self.step_size
        names = tuple(p.name for p in self.ports)
        return Result(time, names, tuple(p.variable.unit_name for p in self.ports), values)

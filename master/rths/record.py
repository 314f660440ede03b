"""A recorded ground motion: two rows or two columns, time [s] and acceleration [m/s2]."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from master.errors import DataError
from master.recording.mat_reader import read_mat
from master.recording.tables import read_table
from master.system.grid import SHARE_OF_A_TICK, ticks_between

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Record:
    """Times [s] from 0 on and accelerations [m/s2], one shape."""

    name: str
    times: Floats
    accelerations: Floats

    def n_ticks(self, step_size: float) -> int:
        """Return the number of steps that the record covers."""
        return int(ticks_between(0.0, float(self.times[-1]), step_size) + SHARE_OF_A_TICK)

    def at_ticks(self, step_size: float) -> Floats:
        """Return the accelerations at the instants of the steps, on straight lines between the samples."""
        ticks = np.arange(self.n_ticks(step_size) + 1, dtype=np.float64)
        return np.interp(ticks * step_size, self.times, self.accelerations)


def read_record(path: Path, scale: float) -> Record:
    """
    Read a record in any format of recordings and scale its accelerations.

    Raises:
        DataError: If it cannot be read, or is no ground motion.
    """
    table = read_table(path, _only_array(path))
    columns = list(table.columns.values())
    lengths = {len(column) for column in columns}
    if len(columns) != 2 and lengths == {2}:
        columns = [np.array([column[row] for column in columns]) for row in range(2)]
    got = f"{len(columns)} columns of {sorted(lengths)} rows"
    if len(columns) != 2 or len(columns[0]) != len(columns[1]) or len(columns[0]) < 2:
        expected = "two columns or two rows: time [s], acceleration [m/s2]"
        raise DataError(f"{path}: no ground motion, got {got}, expected {expected}")
    times = np.asarray(columns[0], dtype=np.float64)
    accelerations = scale * np.asarray(columns[1], dtype=np.float64)
    if not np.all(np.isfinite(times)) or not np.all(np.isfinite(accelerations)):
        raise DataError(f"{path}: value not finite with a scale of {scale:g}, expected finite numbers")
    if times[0] != 0.0 or np.any(np.diff(times) <= 0.0):
        row = int(np.argmax(np.diff(times) <= 0.0)) + 1 if times[0] == 0.0 else 0
        raise DataError(f"{path}: time of sample {row}, got {times[row]:.9g} s, expected it to grow from 0 s")
    if not np.any(accelerations):
        raise DataError(f"{path}: acceleration, got 0 everywhere, expected a motion")
    return Record(path.stem, times, accelerations)


def _only_array(path: Path) -> str | None:
    """Return the name of the one array of a MAT file that has two rows or columns."""
    if path.suffix.lower() != ".mat" or not path.is_file():
        return None
    try:
        arrays = read_mat(path)
    except ValueError:  # whatever it is, the reader of tables says it better
        return None
    found = [name for name, value in arrays.items() if np.ndim(value) == 2 and min(np.shape(value)) == 2]
    return found[0] if len(found) == 1 else None

"""NPZ archives of NumPy."""

from __future__ import annotations

import zipfile
from pathlib import Path

import numpy as np

from .table import Table, by_arrays


def read_npz(path: Path, name: str | None) -> Table:
    """Read the vectors of an archive as columns, or one array of two dimensions."""
    with zipfile.ZipFile(path) as archive:  # the whole of it: NumPy checks no more of an array than it reads
        damaged = archive.testzip()
    if damaged is not None:
        raise ValueError(f"{damaged} is damaged")
    with np.load(path, allow_pickle=False) as found:
        return by_arrays(path, {key: found[key] for key in found.files}, name)

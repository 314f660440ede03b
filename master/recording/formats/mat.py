"""MAT files: up to version 7.2 by SciPy, version 7.3 as the HDF5 that it is."""

from __future__ import annotations

from pathlib import Path

from master.recording.mat_reader import read_mat

from .hdf5 import read_hdf5
from .table import Table, by_arrays

VERSION_7_3 = b"MATLAB 7.3"


def read_matlab(path: Path, name: str | None) -> Table:
    """Read the vectors of a file as columns, those of structures as `structure.field`."""
    with path.open("rb") as file:
        begin = file.read(len(VERSION_7_3))
    if begin == VERSION_7_3:
        return read_hdf5(path, name)
    return by_arrays(path, read_mat(path), name)

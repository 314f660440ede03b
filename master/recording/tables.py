"""Tables of numbers from files, by the format that a file's ending names; the one list of formats."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path

from master.errors import DataError

from .formats.hdf5 import read_hdf5
from .formats.json_rows import read_json, read_json_lines
from .formats.mat import read_matlab
from .formats.mdf import read_mdf
from .formats.npz import read_npz
from .formats.parquet import read_parquet
from .formats.rosbag import METADATA, read_bag
from .formats.table import Table, shortened
from .formats.tdms import read_tdms
from .formats.text import read_text

__all__ = ["FORMATS", "Table", "read_table", "shortened"]

FORMATS: dict[str, Callable[[Path, str | None], Table]] = {
    ".csv": read_text,
    ".txt": read_text,
    ".tsv": read_text,
    ".dat": read_text,
    ".asc": read_text,
    ".json": read_json,
    ".jsonl": read_json_lines,
    ".ndjson": read_json_lines,
    ".npz": read_npz,
    ".mat": read_matlab,
    ".parquet": read_parquet,
    ".h5": read_hdf5,
    ".hdf5": read_hdf5,
    ".mf4": read_mdf,
    ".mdf": read_mdf,
    ".tdms": read_tdms,
    ".bag": read_bag,
    ".db3": read_bag,
    ".mcap": read_bag,
}
"""Reader by the ending of a file; a bag of ROS 2 is a folder."""

_WITH_ARRAYS = (".npz", ".mat", ".h5", ".hdf5")
_LONGEST_REASON = 200
_EMPTY = {EOFError: "it ends too early", MemoryError: "it asks for more memory than there is"}


def read_table(path: str | Path, name: str | None = None) -> Table:
    """
    Read a file by its ending.

    Args:
        path: A file with one of the endings in `FORMATS`, or the folder of a bag of ROS 2.
        name: Array of two dimensions to take from an NPZ, MAT or HDF5 file; its columns are named by an array
            `columns` next to it, or by their numbers.

    Raises:
        DataError: If the file cannot be read as a table.
    """
    path = Path(path)
    is_bag = os.path.isfile(path / METADATA)
    reader = read_bag if is_bag else FORMATS.get(path.suffix.lower())
    if reader is None:
        raise DataError(f"{path}: kind of file, got {path.suffix!r}, expected one of {[*FORMATS]}")
    if not is_bag and not os.path.isfile(path):  # unlike Path.is_file, False for a name that no file may have
        raise DataError(f"{path}: no such file")
    if name is not None and path.suffix.lower() not in _WITH_ARRAYS:
        raise DataError(f"{path}: array, got {name!r}, expected none: only NPZ, MAT and HDF5 have arrays")
    try:
        return reader(path, name)
    except DataError:
        raise
    except Exception as error:  # the libraries raise anything at a damaged file
        reason = " ".join(str(error).split()) or _EMPTY.get(type(error), type(error).__name__)
        if len(reason) > _LONGEST_REASON:
            reason = reason[:_LONGEST_REASON] + "..."
        raise DataError(f"{path}: cannot be read as a table: {reason}") from error

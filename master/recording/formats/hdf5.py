"""
HDF5 files, and the MAT files of version 7.3 that are some.

A data set in folders is named `folder/name`, in a MAT file `structure.field`; fields of a compound data set
are columns. `scale_factor` and `add_offset` are applied, as netCDF defines them.
"""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np

from .table import NUMBERS, Table, by_arrays, library

_TEXT = "char"  # what MATLAB stores as numbers, too


def read_hdf5(path: Path, name: str | None) -> Table:
    """Read the vectors of a file as columns, or one array of two dimensions."""
    h5py = library("h5py", "h5py", path)
    arrays: dict[str, Any] = {}
    units: dict[str, str] = {}

    def take(key: str, item: Any) -> None:
        if not isinstance(item, h5py.Dataset) or key.startswith("#"):
            return
        matlab = item.attrs.get("MATLAB_class")
        shown = key if matlab is None else key.replace("/", ".")
        values = _values(item, matlab)
        if values is None:
            return
        if values.dtype.names:
            arrays.update({f"{shown}.{field}": values[field] for field in values.dtype.names})
            return
        arrays[shown] = values
        unit = item.attrs.get("units", item.attrs.get("unit"))
        if unit is not None:
            units[shown] = unit.decode(errors="replace") if isinstance(unit, bytes) else str(unit)

    with h5py.File(path, "r") as file:
        file.visititems(take)
    if not arrays:
        raise ValueError("no numbers in it, expected data sets of numbers")
    table = by_arrays(path, arrays, name)
    table.units = {key: unit for key, unit in units.items() if key in table.columns}
    return table


def _values(item: Any, matlab: bytes | str | None) -> Any:
    """Values of a data set as they are meant; None for an empty one or one of references."""
    if item.shape is None or item.attrs.get("MATLAB_empty") or item.dtype.kind == "O":
        return None
    values = item[()]
    if matlab is not None:
        word = matlab.decode() if isinstance(matlab, bytes) else matlab
        return None if word == _TEXT else np.transpose(values)  # MATLAB stores columns, HDF5 rows
    if np.asarray(values).dtype.kind not in NUMBERS:
        return np.asarray(values)
    fill = item.attrs.get("_FillValue")
    is_filled = None if fill is None else np.asarray(values) == np.ravel(fill)[0]
    scale = float(np.ravel(item.attrs.get("scale_factor", 1.0))[0])
    offset = float(np.ravel(item.attrs.get("add_offset", 0.0))[0])
    if scale != 1.0 or offset != 0.0:
        values = scale * np.asarray(values, dtype=float) + offset
    return values if is_filled is None else np.where(is_filled, math.nan, values)

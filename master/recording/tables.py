"""Tables of numbers from CSV, MAT, NPZ and Parquet files, with the faults of the file."""

from __future__ import annotations

import csv
import math
import os
import zipfile
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from master.errors import DataError

from .mat_reader import read_mat

Array = NDArray[np.float64]

N_SHOWN = 5  # faults of a kind that are shown
_LONGEST_REASON = 200
_EMPTY = {EOFError: "it ends too early", MemoryError: "it asks for more memory than there is"}
_NUMBERS = "fiub"  # kinds of NumPy's types


class Table:
    """
    Columns of a file.

    `columns` have the lengths that the file gives, `first_row` is the number that people see for row 0 (2
    in a CSV with a header), `faults` are the cells that are no numbers, by column; "" are faults of whole
    rows.
    """

    def __init__(self, path: Path, columns: Mapping[str, Array], first_row: int = 0) -> None:
        self.path = path
        self.columns = dict(columns)
        self.first_row = first_row
        self.faults: dict[str, list[str]] = {}


def read_table(path: str | Path, name: str | None = None) -> Table:
    """
    Read a file by its ending.

    Args:
        path: `.csv`, `.mat` (up to version 7.2), `.npz` or `.parquet`.
        name: Array of two dimensions to take from an NPZ or MAT; its columns are named by an array `columns`
            next to it, or by their numbers.

    Raises:
        DataError: If the file cannot be read as a table.
    """
    path = Path(path)
    reader = _READERS.get(path.suffix.lower())
    if reader is None:
        raise DataError(f"{path}: kind of file, got {path.suffix!r}, expected one of {[*_READERS]}")
    if not os.path.isfile(path):  # unlike Path.is_file, False for a name that no file may have
        raise DataError(f"{path}: no such file")
    if name is not None and path.suffix.lower() not in (".npz", ".mat"):
        raise DataError(f"{path}: array, got {name!r}, expected none: only NPZ and MAT have arrays")
    try:
        return reader(path, name)
    except Exception as error:  # the libraries raise anything at a damaged file
        reason = " ".join(str(error).split()) or _EMPTY.get(type(error), type(error).__name__)
        if len(reason) > _LONGEST_REASON:
            reason = reason[:_LONGEST_REASON] + "..."
        raise DataError(f"{path}: cannot be read as a table: {reason}") from error


def _csv(path: Path, _: str | None) -> Table:
    """Read a file without faults at once; any other cell by cell, to name what is wrong."""
    return _csv_at_once(path) or _csv_by_cells(path)


def _csv_at_once(path: Path) -> Table | None:
    """Return the table of a file whose cells are all numbers, else None."""
    import pyarrow as pa
    from pyarrow import csv as arrow_csv

    try:
        with path.open(newline="", encoding="utf-8-sig") as file:
            header = next(csv.reader(file), [])
        # the types are given: of integers the reader would take notations that others are not
        types = arrow_csv.ConvertOptions(column_types=dict.fromkeys(header, pa.float64()))
        found = arrow_csv.read_csv(str(path), convert_options=types)
    except (pa.ArrowException, OSError, ValueError, csv.Error):
        return None
    names = [name.strip() for name in found.column_names]
    are_numbers = all(pa.types.is_floating(column.type) for column in found.columns)
    if not (are_numbers and len(set(names)) == len(names) and not any(c.null_count for c in found.columns)):
        return None
    values = [column.to_numpy().astype(np.float64) for column in found.columns]
    return Table(path, dict(zip(names, values, strict=True)), first_row=2)


def _csv_by_cells(path: Path) -> Table:
    with path.open(newline="", encoding="utf-8-sig") as file:
        rows = list(csv.reader(file))
    if not rows:
        raise ValueError("the file is empty, expected a header")
    header = [cell.strip() for cell in rows[0]]
    body = rows[1:]
    other = next((sign for sign in (";", "\t") if len(header) == 1 and sign in header[0]), None)
    if other is not None:
        raise ValueError(f"cells are separated by {other!r}, expected ','")
    faults: dict[str, list[str]] = {
        name: [f"{path}: column {name!r} is there {header.count(name)} times, expected once"]
        for name in header
        if header.count(name) > 1
    }
    values = np.full((len(body), len(header)), math.nan)
    for i, row in enumerate(body):
        if row and len(row) != len(header):
            text = f"{path}: row {i + 2}: got {len(row)} cells, expected {len(header)}"
            faults.setdefault("", []).append(text)
        for j, cell in enumerate(row[: len(header)]):
            try:
                values[i, j] = _number(cell)
            except ValueError:
                text = f"{path}: row {i + 2}, column {header[j]!r}: got {cell!r}, expected a number"
                faults.setdefault(header[j], []).append(text)
    kept = [i for i, row in enumerate(body) if row]  # without blank lines
    table = Table(path, {name: values[kept, j] for j, name in enumerate(header)}, first_row=2)
    table.faults = {name: shortened(own, "in this column") for name, own in faults.items()}
    return table


def _number(cell: str) -> float:
    """Return the number of a cell; Python's own notations (`1_000`, digits of other scripts) are none."""
    if "_" in cell or not cell.isascii():
        raise ValueError("not a number")
    return float(cell)


def _npz(path: Path, name: str | None) -> Table:
    with zipfile.ZipFile(path) as archive:  # the whole of it: NumPy checks no more of an array than it reads
        damaged = archive.testzip()
    if damaged is not None:
        raise ValueError(f"{damaged} is damaged")
    with np.load(path, allow_pickle=False) as found:
        return _arrays(path, {key: found[key] for key in found.files}, name)


def _mat(path: Path, name: str | None) -> Table:
    return _arrays(path, read_mat(path), name)


def _parquet(path: Path, _: str | None) -> Table:
    import pyarrow.parquet

    table = pyarrow.parquet.read_table(path)
    return _by_columns(path, {key: table[key].to_numpy() for key in table.column_names})


def _arrays(path: Path, arrays: Mapping[str, Any], name: str | None) -> Table:
    if name is None:
        flat = {key: np.squeeze(value) for key, value in arrays.items()}
        columns = {key: v for key, v in flat.items() if v.ndim == 1 and v.size > 1}
        if not columns:
            raise ValueError(f"no columns, expected the name of an array, one of {[*arrays]}")
        return _by_columns(path, columns)
    if name not in arrays:
        raise ValueError(f"no array of this name, got {name!r}, expected one of {[*arrays]}")
    if np.asarray(arrays[name]).dtype.kind not in _NUMBERS:
        raise ValueError(f"array {name!r}: got values of type {arrays[name].dtype}, expected numbers")
    values = np.asarray(arrays[name], dtype=float)
    if values.ndim != 2:
        raise ValueError(f"array {name!r}: got {values.ndim} dimensions, expected 2")
    names = [str(i) for i in range(values.shape[1])]
    if "columns" in arrays:
        names = [str(np.squeeze(n)).strip() for n in np.ravel(arrays["columns"])]
    if len(names) != values.shape[1]:
        raise ValueError(f"array 'columns': got {len(names)} names, expected {values.shape[1]}")
    return Table(path, {n: values[:, j] for j, n in enumerate(names)})


def _by_columns(path: Path, columns: Mapping[str, Any]) -> Table:
    """Take columns of numbers; others are a fault of their own, for who asks for them."""
    kinds = {key: np.asarray(v).dtype for key, v in columns.items()}
    strange = {key: kind for key, kind in kinds.items() if kind.kind not in _NUMBERS}
    numbers = {key: np.full(len(v), math.nan) if key in strange else v for key, v in columns.items()}
    table = Table(path, {key: np.asarray(v, dtype=float) for key, v in numbers.items()})
    table.faults = {
        key: [f"{path}: column {key!r}: got values of type {kind}, expected numbers"]
        for key, kind in strange.items()
    }
    return table


def shortened(faults: list[str], kind: str) -> list[str]:
    """Show the first few and count the others."""
    if len(faults) <= N_SHOWN:
        return faults
    return [*faults[:N_SHOWN], f"... and {len(faults) - N_SHOWN} more {kind}"]


_READERS: dict[str, Callable[[Path, str | None], Table]] = {
    ".csv": _csv,
    ".npz": _npz,
    ".mat": _mat,
    ".parquet": _parquet,
}

"""A table as every format gives it: columns of numbers, and what is wrong with them."""

from __future__ import annotations

import importlib
import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from master.errors import DataError

Array = NDArray[np.float64]

N_SHOWN = 5  # faults of a kind that are shown
NUMBERS = "fiub"  # kinds of NumPy's types
NANOSECONDS = 1_000_000_000  # in a second


class Table:
    """
    Columns of a file.

    `columns` have the lengths that the file gives, `first_row` is the number that people see for row 0 (2
    in a CSV with a header), `faults` are the cells that are no numbers, by column; "" are faults of whole
    rows. `units` are what the file says of its columns, `dates` the columns that held dates and are seconds
    since their first row, `notes` what the reader took for granted. `clocks` name the column that stamps
    each column, where a file has several.
    """

    def __init__(self, path: Path, columns: Mapping[str, Array], first_row: int = 0) -> None:
        self.path = path
        self.columns = dict(columns)
        self.first_row = first_row
        self.faults: dict[str, list[str]] = {}
        self.units: dict[str, str] = {}
        self.dates: set[str] = set()
        self.notes: list[str] = []
        self.clocks: dict[str, str] = {}


def by_columns(path: Path, columns: Mapping[str, Any]) -> Table:
    """Take columns of numbers or dates; others are a fault of their own, for who asks for them."""
    table = Table(path, {})
    for key, given in columns.items():
        values = np.asarray(given)
        if values.dtype.kind == "M":
            table.columns[key] = seconds_since_first(values)
            table.dates.add(key)
        elif values.dtype.kind in NUMBERS:
            table.columns[key] = values.astype(float)
        else:
            table.columns[key] = np.full(len(values), math.nan)
            text = f"{path}: column {key!r}: got values of type {values.dtype}, expected numbers"
            table.faults[key] = [text]
    return table


def by_arrays(path: Path, arrays: Mapping[str, Any], name: str | None) -> Table:
    """
    Take the vectors among arrays as columns; with `name`, the columns of that array of two dimensions.

    Raises:
        ValueError: If there are no columns, or the array has another shape or kind.
    """
    if name is None:
        flat = {key: np.squeeze(value) for key, value in arrays.items()}
        columns = {key: v for key, v in flat.items() if v.ndim == 1 and v.size > 1}
        if not columns:
            raise ValueError(f"no columns, expected the name of an array, one of {[*arrays]}")
        return by_columns(path, columns)
    if name not in arrays:
        raise ValueError(f"no array of this name, got {name!r}, expected one of {[*arrays]}")
    if np.asarray(arrays[name]).dtype.kind not in NUMBERS:
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


def seconds_since_first(dates: NDArray[np.datetime64]) -> Array:
    """Return seconds since the first of some dates, shape (n,); what is no date is NaN."""
    if not len(dates):
        return np.empty(0)
    exact = dates.astype("datetime64[ns]")
    apart = (exact - exact[0]).astype(np.int64)
    return np.where(np.isnat(exact), math.nan, apart / NANOSECONDS)


def shortened(faults: list[str], kind: str) -> list[str]:
    """Show the first few and count the others."""
    if len(faults) <= N_SHOWN:
        return faults
    return [*faults[:N_SHOWN], f"... and {len(faults) - N_SHOWN} more {kind}"]


def library(module: str, package: str, path: Path) -> Any:
    """
    Import what only some formats need.

    Raises:
        DataError: If it is not installed, with the command that installs it.
    """
    try:
        return importlib.import_module(module)
    except ImportError:
        raise DataError(
            f"{path}: package {package}: not installed, got none, expected pip install 'dockloop[data]'"
        ) from None

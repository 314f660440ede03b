"""Rows of a run as they are compared: from a results folder, or from a file of any tool."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from master.errors import DataError
from master.recording.folder import CSV, PARQUET, PARTS
from master.recording.tables import read_table

Floats = NDArray[np.float64]

_TIMES = ("time", "t")  # names of the column of times, in any case; the first is preferred


@dataclass(frozen=True)
class RunData:
    """
    Rows of a run.

    `time` [s] and each signal have shape (rows,); `units` are empty where a file has none. `label` is what
    the user called it, `file` what was read.
    """

    label: str
    file: Path
    time: Floats
    signals: Mapping[str, Floats]
    units: Mapping[str, str]


def read_run(path: Path) -> RunData:
    """
    Read a results folder, or a CSV, Parquet, NPZ or MAT file with a column `time` or `t` in s.

    Raises:
        DataError: If there is no such run, a cell is no number, or the times do not increase.
    """
    files = _files_of(path)
    file = files[0]
    tables = [read_table(one) for one in files]
    table = tables[0]
    faults = [fault for one in tables for own in one.faults.values() for fault in own]
    if faults:
        raise DataError("\n".join(faults))
    columns = dict(table.columns)
    if len(tables) > 1:
        columns = {name: np.concatenate([one.columns[name] for one in tables]) for name in columns}
    name = next((c for wanted in _TIMES for c in columns if c.strip().lower() == wanted), None)
    if name is None:
        shown = ", ".join(columns) or "none"
        raise DataError(f"{file}: no column of times, got {shown}, expected one of {', '.join(_TIMES)}")
    time = columns.pop(name)
    lengths = {key: len(v) for key, v in columns.items() if len(v) != len(time)}
    if lengths:
        key, n = next(iter(lengths.items()))
        raise DataError(f"{file}: column {key!r}, got {n} rows, expected {len(time)} as of {name!r}")
    _refuse_wrong_times(file, time, table.first_row)
    return RunData(str(path), file, time, columns, _units(file))


def _files_of(path: Path) -> list[Path]:
    """Files that hold the rows; those of a run that goes on, or was killed, are in whole parts."""
    if not path.is_dir():
        return [path]
    whole = path / PARQUET
    parts = sorted(path.glob(PARTS))
    if parts and not whole.is_file():
        return parts
    for file in (whole, path / CSV):
        if file.is_file():
            return [file]
    raise DataError(f"{path}: no results, expected {PARQUET} or {CSV} in it")


def _refuse_wrong_times(file: Path, time: Floats, first_row: int) -> None:
    if len(time) == 0:
        raise DataError(f"{file}: no rows, expected one at least")
    wrong = np.flatnonzero(~np.isfinite(time))
    if len(wrong):
        raise DataError(f"{file}: row {wrong[0] + first_row}: time, got {time[wrong[0]]}, expected a number")
    back = np.flatnonzero(np.diff(time) < 0.0)
    if len(back):
        row = back[0] + 1
        expected = f"at least {time[row - 1]:.15g} as in the row before"
        raise DataError(f"{file}: row {row + first_row}: time, got {time[row]:.15g} s, expected {expected}")


def _units(file: Path) -> dict[str, str]:
    if file.suffix.lower() != ".parquet":
        return {}
    from pyarrow import parquet

    schema = parquet.read_schema(str(file))
    units = {field.name: (field.metadata or {}).get(b"unit", b"").decode() for field in schema}
    return {name: unit for name, unit in units.items() if unit}

"""Result files that other tools open: CSV in FMPy's form, Parquet with units."""

from __future__ import annotations

from pathlib import Path
from types import TracebackType
from typing import Any

import numpy as np

from .recorder import Result

CSV, PARQUET = "result.csv", "result.parquet"


class ResultFiles:
    """
    result.csv and result.parquet in a folder, written row by row or at once.

    CSV: `"time","instance.variable",...` with all digits, one row a communication point. Parquet: one
    column a signal, its unit in the field's metadata under `unit`.
    """

    def __init__(self, folder: Path) -> None:
        folder.mkdir(parents=True, exist_ok=True)
        self.csv, self.parquet = folder / CSV, folder / PARQUET
        self._writers: list[Any] = []

    def write(self, result: Result) -> None:
        """Append rows."""
        table = _table(result)
        if not self._writers:
            from pyarrow import csv, parquet

            self._writers = [
                csv.CSVWriter(str(self.csv), table.schema),
                parquet.ParquetWriter(str(self.parquet), table.schema),
            ]
        for writer in self._writers:
            writer.write_table(table)

    def __enter__(self) -> ResultFiles:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        for writer in self._writers:
            writer.close()


def write_result(result: Result, folder: Path) -> ResultFiles:
    """Write a whole result."""
    with ResultFiles(folder) as files:
        files.write(result)
    return files


def read_csv(path: Path) -> Result:
    """Read a CSV of this form back; units are not in it."""
    from pyarrow import csv

    table = csv.read_csv(str(path))
    names = tuple(table.column_names[1:])
    columns = [table.column(name).to_numpy() for name in table.column_names]
    values = np.column_stack(columns[1:]) if names else np.empty((len(columns[0]), 0))
    return Result(columns[0], names, ("",) * len(names), values)


def _table(result: Result) -> Any:
    import pyarrow as pa

    columns = {"time": (result.time, "s")} | {
        name: (result.values[:, i], unit)
        for i, (name, unit) in enumerate(zip(result.names, result.units, strict=True))
    }
    fields = [pa.field(name, pa.float64(), metadata={"unit": unit}) for name, (_, unit) in columns.items()]
    return pa.table([pa.array(values) for values, _ in columns.values()], schema=pa.schema(fields))

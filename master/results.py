"""Result files that other tools open: CSV in FMPy's form, Parquet with units."""

from __future__ import annotations

from pathlib import Path

from .recorder import Result


def write_csv(result: Result, path: Path) -> Path:
    """Write `"time","instance.variable",...` with all digits, one row a communication point."""
    from pyarrow import csv

    csv.write_csv(_table(result), str(path))
    return path


def write_parquet(result: Result, path: Path) -> Path:
    """Write one column a signal, its unit in the field's metadata under `unit`."""
    from pyarrow import parquet

    parquet.write_table(_table(result), str(path))
    return path


def read_csv(path: Path) -> Result:
    """Read a CSV of this form back; units are not in it."""
    from pyarrow import csv

    table = csv.read_csv(str(path))
    names = tuple(table.column_names[1:])
    columns = [table.column(name).to_numpy() for name in table.column_names]
    import numpy as np

    values = np.column_stack(columns[1:]) if names else np.empty((len(columns[0]), 0))
    return Result(columns[0], names, ("",) * len(names), values)


def _table(result: Result):  # type: ignore[no-untyped-def]
    import pyarrow as pa

    columns = {"time": (result.time, "s")} | {
        name: (result.values[:, i], unit)
        for i, (name, unit) in enumerate(zip(result.names, result.units, strict=True))
    }
    fields = [pa.field(name, pa.float64(), metadata={"unit": unit}) for name, (_, unit) in columns.items()]
    return pa.table([pa.array(values) for values, _ in columns.values()], schema=pa.schema(fields))

"""Parquet files, with the units that dockloop writes to their fields."""

from __future__ import annotations

from pathlib import Path

from .table import Table, by_columns


def read_parquet(path: Path, _: str | None) -> Table:
    """Read all columns; a column of dates becomes seconds since its first row."""
    import pyarrow.parquet

    table = pyarrow.parquet.read_table(path)
    found = by_columns(path, {key: table[key].to_numpy() for key in table.column_names})
    for field in table.schema:
        unit = (field.metadata or {}).get(b"unit")
        if unit is not None:
            found.units[field.name] = unit.decode(errors="replace")
    return found

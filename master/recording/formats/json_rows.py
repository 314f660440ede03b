"""JSON: a list of rows, an object of columns, or a row a line; fields of fields are `outer.inner`."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from .iso_time import instants
from .table import Table, seconds_since_first, shortened


def read_json(path: Path, _: str | None) -> Table:
    """Read a list of rows, or an object of columns."""
    text = path.read_text(encoding="utf-8-sig")
    try:
        content = json.loads(text)
    except json.JSONDecodeError as error:
        if error.msg != "Extra data":
            raise
        return read_json_lines(path, None)
    if isinstance(content, dict):
        lists = {key: v for key, v in content.items() if isinstance(v, list)}
        rows = [v for v in lists.values() if v and all(isinstance(row, dict) for row in v)]
        if len(rows) > 1:
            raise ValueError("several lists of rows, expected one")
        if not rows:
            return _table(path, lists)
        content = rows[0]
    if not (isinstance(content, list) and content and all(isinstance(row, dict) for row in content)):
        raise ValueError("no rows, expected a list of objects, or an object of lists")
    return _table(path, _columns(content))


def read_json_lines(path: Path, _: str | None) -> Table:
    """Read one object a line."""
    lines = path.read_text(encoding="utf-8-sig").splitlines()
    rows = []
    for i, line in enumerate(lines):
        if not line.strip():
            continue
        try:
            row = json.loads(line)
        except json.JSONDecodeError as error:
            raise ValueError(f"line {i + 1}: {error.msg}, expected an object") from None
        if not isinstance(row, dict):
            raise ValueError(f"line {i + 1}: got {line.strip()[:40]!r}, expected an object")
        rows.append(row)
    return _table(path, _columns(rows), first_row=1)


def _columns(rows: list[dict[str, Any]]) -> dict[str, list[Any]]:
    flat = [dict(_flat(row, "")) for row in rows]
    return {key: [row.get(key) for row in flat] for key in dict.fromkeys(k for row in flat for k in row)}


def _flat(row: Mapping[str, Any], prefix: str) -> Iterator[tuple[str, Any]]:
    for key, value in row.items():
        if isinstance(value, dict):
            yield from _flat(value, f"{prefix}{key}.")
        elif isinstance(value, list):
            yield from ((f"{prefix}{key}.{i}", entry) for i, entry in enumerate(value))
        else:
            yield f"{prefix}{key}", value


def _table(path: Path, columns: Mapping[str, list[Any]], first_row: int = 0) -> Table:
    if not columns:
        raise ValueError("no columns, expected a list of objects, or an object of lists")
    table = Table(path, {}, first_row)
    for key, cells in columns.items():
        dates = instants(cells) if cells and isinstance(cells[0], str) else None
        if dates is not None:
            table.columns[key] = seconds_since_first(dates)
            table.dates.add(key)
            continue
        is_number = [isinstance(cell, (int, float)) and not isinstance(cell, bool) for cell in cells]
        numbers = [float(c) if good else math.nan for c, good in zip(cells, is_number, strict=True)]
        table.columns[key] = np.array(numbers)
        faults = [
            f"{path}: row {i + first_row}, column {key!r}: got {cell!r}, expected a number"
            for i, (cell, good) in enumerate(zip(cells, is_number, strict=True))
            if not good
        ]
        if faults:
            table.faults[key] = shortened(faults, "in this column")
    return table

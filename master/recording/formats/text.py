"""
Text files of columns: CSV and what goes by that name.

Separated by commas, semicolons, tabs or spaces; with decimal points or commas; with a preamble, comments, one
header line, two, or none; in UTF-8, UTF-16 or Latin-1. What the file does not prove is refused.
"""

from __future__ import annotations

import codecs
import csv
import math
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from .iso_time import instants, is_instant
from .number_text import looks_like_number, number, proven
from .table import Array, Table, seconds_since_first, shortened
from .text_layout import SEPARATORS, Layout, layout


def read_text(path: Path, _: str | None) -> Table:
    """Read a file without faults at once; any other cell by cell, to name what is wrong."""
    return _at_once(path) or _by_cells(path)


def _at_once(path: Path) -> Table | None:
    """Return the table of a file with one header line, commas and points, whose cells are all numbers."""
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
    if not all(name and not name.startswith(("#", "%", "/")) and not _is_plain(name) for name in names):
        return None
    values = [column.to_numpy().astype(np.float64) for column in found.columns]
    return Table(path, dict(zip(names, values, strict=True)), first_row=2)


def _is_plain(name: str) -> bool:
    try:
        float(name.replace(",", "."))
    except ValueError:
        return False
    return True


def _decoded(path: Path) -> str:
    content = path.read_bytes()
    if content.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)):
        return content.decode("utf-16")
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError:
        return content.decode("latin-1")


def _by_cells(path: Path) -> Table:
    found = layout(_decoded(path))
    names, units = _complete(found)
    table = Table(path, {}, first_row=found.rows[0].number if found.rows else 2)
    faults: dict[str, list[str]] = {
        name: [f"{path}: column {name!r} is there {names.count(name)} times, expected once"]
        for name in dict.fromkeys(names)
        if names.count(name) > 1
    }
    for row in found.rows:
        if len(row.cells) < len(names) or any(row.cells[len(names) :]):
            text = f"{path}: row {row.number}: got {len(row.cells)} cells, expected {len(names)}"
            faults.setdefault("", []).append(text)
    columns = [[row.cells[j] if j < len(row.cells) else "" for row in found.rows] for j in range(len(names))]
    own = [proven(cells) for cells in columns]
    of_file = set[str]().union(*own)
    if not any("," in cell and looks_like_number(cell) for cells in columns for cell in cells):
        of_file = {"."}
    for name, cells, signs in zip(names, columns, own, strict=True):
        decimal = _only(signs or of_file)
        table.columns[name] = _column(table, name, cells, found, decimal, faults)
    table.units = {name: unit for name, unit in zip(names, units, strict=True) if unit}
    table.faults = {name: shortened(texts, "in this column") for name, texts in faults.items()}
    table.notes = _notes(found, of_file)
    return table


def _complete(found: Layout) -> tuple[list[str], list[str]]:
    """Names and units of the columns: without those that trailing separators leave, unnamed ones numbered."""
    names = list(found.names)
    units = [*found.units, *[""] * (len(names) - len(found.units))][: len(names)]
    while len(names) > 1 and not names[-1]:
        j = len(names) - 1
        if any(len(row.cells) > j and row.cells[j] for row in found.rows):
            break
        names.pop()
        units.pop()
    if not found.has_names:
        while len(names) > 1 and not any(
            row.cells[len(names) - 1] for row in found.rows if len(row.cells) >= len(names)
        ):
            names.pop()
            units.pop()
    return [name or str(j) for j, name in enumerate(names)], units


def _column(
    table: Table,
    name: str,
    cells: Sequence[str],
    found: Layout,
    decimal: str | None,
    faults: dict[str, list[str]],
) -> Array:
    """Numbers of a column, NaN where a cell is none; dates as seconds since the first."""
    if cells and is_instant(cells[0]):
        dates = instants(cells)
        if dates is not None:
            table.dates.add(name)
            return seconds_since_first(dates)
    values = np.full(len(cells), math.nan)
    is_proven = bool(proven(cells))
    for i, cell in enumerate(cells):
        try:
            values[i] = number(cell, decimal, is_proven=is_proven)
        except ValueError as error:
            row = found.rows[i].number
            text = f"{table.path}: row {row}, column {name!r}: got {cell!r}, expected {error}"
            faults.setdefault(name, []).append(text)
    return values


def _only(signs: set[str]) -> str | None:
    """Return the decimal sign that is proven; None for none, or where cells need both."""
    return next(iter(signs)) if len(signs) == 1 else None


def _notes(found: Layout, decimals: set[str]) -> list[str]:
    notes = [f"cells separated by {SEPARATORS[found.separator]}"]
    if decimals == {","}:
        notes.append("decimal commas")
    if found.skipped:
        notes.append(f"{found.skipped} lines of preamble")
    if not found.has_names:
        notes.append("no header: columns are named 0, 1, ...")
    return notes

"""
How a text file is laid out: what separates its cells, where its rows begin, and what names its columns.

The end of a file shows it best: there are rows alone. A column is one of numbers if most of its cells there
are. Lines above the rows are a header where no such column has a number, a preamble where they have another
number of cells.
"""

from __future__ import annotations

import csv
import re
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

from .iso_time import is_instant
from .number_text import MISSING, looks_like_number

SEPARATORS = {";": "semicolons", "\t": "tabs", ",": "commas", " ": "spaces"}
COMMENTS = ("#", "%", "//")
_SAMPLE = 200  # rows at the end that show the layout
_SEARCHED = 500  # lines at the begin, among which the rows begin
_UNITS = frozenset(
    (
        *("s", "ms", "us", "µs", "ns", "sec", "min", "h", "Hz", "kHz"),
        *("m", "mm", "um", "µm", "cm", "km", "in", "inch", "ft", "rad", "mrad", "deg", "°", "rev", "rpm"),
        *("N", "kN", "mN", "Nm", "lb", "lbf", "kip", "kg", "g", "Pa", "kPa", "MPa", "mbar", "bar", "psi"),
        *("V", "mV", "A", "mA", "W", "kW", "J", "K", "C", "degC", "°C", "l", "L", "%", "count", "counts"),
    )
)
_BRACKETED = re.compile(r"[\[(<{].*[\])>}]")


@dataclass(frozen=True)
class Line:
    """A line that is neither blank nor a comment: its number in the file and its cells."""

    number: int
    cells: list[str]


@dataclass(frozen=True)
class Layout:
    """
    What separates cells, the names and units of the columns, and the rows.

    `has_names` is False where the columns are named by their position, 0, 1, ...
    """

    separator: str
    names: list[str]
    units: list[str]
    has_names: bool
    rows: list[Line]
    skipped: int = 0


def split_lines(lines: Sequence[tuple[int, str]], separator: str) -> list[Line]:
    """Split numbered lines into cells without blanks around them; quotes hold cells together."""
    texts = [text for _, text in lines]
    if separator == " ":
        texts = [text.replace("\t", " ").strip() for text in texts]
    reader = csv.reader(texts, delimiter=separator, skipinitialspace=True)
    return [Line(lines[reader.line_num - 1][0], [cell.strip() for cell in cells]) for cells in reader]


def layout(text: str) -> Layout:
    """
    Find the layout of a text.

    Raises:
        ValueError: If it has no row.
    """
    numbered = [(i + 1, line) for i, line in enumerate(re.split(r"\r\n|\n|\r", text)) if line.strip()]
    comments = [(i, line) for i, line in numbered if line.lstrip().startswith(COMMENTS)]
    lines = [(i, line) for i, line in numbered if not line.lstrip().startswith(COMMENTS)]
    if not lines:
        raise ValueError("the file is empty, expected a header")
    separator = _separator(lines)
    rows = split_lines(lines, separator)
    width = _width(rows)
    numeric = _numeric(rows, width)
    begin, first_header = _begin(rows, numeric, width)
    header = rows[first_header:begin]
    if not header:
        named = _named_by_comment(comments, rows[begin].number, separator, width)
        if named is not None:
            return Layout(separator, named, [""] * len(named), True, rows[begin:], begin)
        _refuse_unclear(rows[begin], separator)
        return Layout(separator, [str(j) for j in range(width)], [""] * width, False, rows[begin:], begin)
    names, units = _names(header)
    return Layout(separator, names, units, True, rows[begin:], first_header)


def is_value(cell: str) -> bool:
    """Return whether a cell holds a number or an instant."""
    return looks_like_number(cell) or is_instant(cell)


def _separator(lines: Sequence[tuple[int, str]]) -> str:
    """The sign with which most of the cells at the end are values; of equals, the first that separates."""
    tail = lines[max(1, len(lines) // 2) :][-_SAMPLE:] or lines[-1:]
    best = ","
    best_score = (-1.0, False)
    for separator in SEPARATORS:
        try:
            rows = split_lines(tail, separator)
        except csv.Error:
            continue
        cells = [cell for row in rows for cell in row.cells if cell.lower() not in MISSING]
        share = sum(map(is_value, cells)) / max(1, len(cells))
        width = _width(rows)
        if width == 1 and separator == " " and any(len(row.cells) > 1 for row in rows):
            continue
        score = (share, width > 1)
        if score > best_score:
            best, best_score = separator, score
    return best


def _width(rows: Sequence[Line]) -> int:
    """The usual number of cells of the rows at the end."""
    return Counter(len(row.cells) for row in rows[len(rows) // 2 :][-_SAMPLE:]).most_common(1)[0][0]


def _numeric(rows: Sequence[Line], width: int) -> list[int]:
    """Columns whose cells at the end are values, half of them or more."""
    tail = [row.cells for row in rows[len(rows) // 2 :][-_SAMPLE:] if len(row.cells) == width]
    return [j for j in range(width) if 2 * sum(is_value(cells[j]) for cells in tail) >= len(tail)]


def _begin(rows: Sequence[Line], numeric: Sequence[int], width: int) -> tuple[int, int]:
    """Places of the first row of numbers and of the first line of its header; the same without one."""
    if not numeric:
        return (1, 0) if len(rows) > 1 else (len(rows), 0)

    def values(i: int) -> int:
        cells = rows[i].cells
        return sum(j < len(cells) and (is_value(cells[j]) or cells[j].lower() in MISSING) for j in numeric)

    searched = range(min(len(rows), _SEARCHED))
    full = next((i for i in searched if len(rows[i].cells) >= width and values(i) == len(numeric)), 0)
    titles = [i for i in range(full) if _is_title(rows[i], numeric)]
    if titles:
        last = titles[-1]
        begin = last + 1
        has_two = (
            last > 0
            and _is_title(rows[last - 1], numeric)
            and len(rows[last - 1].cells) == len(rows[last].cells)
        )
        if has_two and (len(rows[last].cells) > 1 or _BRACKETED.fullmatch(rows[last].cells[0])):
            return begin, last - 1
        if has_two:  # one column: a word below its name is a cell that is no number
            return last, last - 1
        return begin, last
    if full == 1 and _some_text(rows[0]):  # names, some of which are numbers
        return 1, 0
    return 0, 0


def _is_title(row: Line, numeric: Sequence[int]) -> bool:
    """Whether a line may name columns: several cells, and none of a column of numbers holds one."""
    cells = row.cells
    own = [cells[j] for j in numeric if j < len(cells)]
    if len(numeric) > 1 and sum(cell != "" for cell in cells) < 2:
        return False
    return bool(own) and any(own) and not any(is_value(cell) for cell in own)


def _some_text(row: Line) -> bool:
    return any(cell and not is_value(cell) for cell in row.cells)


def _names(header: Sequence[Line]) -> tuple[list[str], list[str]]:
    """Names and units of the columns, from one line or two."""
    first = header[0].cells
    if len(header) == 1:
        return first, [""] * len(first)
    second = header[1].cells
    if _is_distinct(first) and all(_is_unit(cell) for cell in second):
        return first, second
    if _is_distinct(second):
        return second, [""] * len(second)
    groups: list[str] = []
    for cell in first:
        groups.append(cell or (groups[-1] if groups else ""))
    return [f"{group} {name}".strip() for group, name in zip(groups, second, strict=True)], [""] * len(second)


def _is_unit(cell: str) -> bool:
    """Whether a cell below a name is a unit: in brackets, nothing, or of the usual symbols."""
    if cell in ("", "-", "1") or _BRACKETED.fullmatch(cell):
        return True
    symbols = [symbol for symbol in re.split(r"[\s/*·^.()\d²³-]+", cell) if symbol]
    return bool(symbols) and all(symbol in _UNITS for symbol in symbols)


def _is_distinct(cells: Sequence[str]) -> bool:
    named = [cell for i, cell in enumerate(cells) if cell or any(cells[i:])]
    return "" not in named and len(set(named)) == len(named)


def _named_by_comment(
    comments: Sequence[tuple[int, str]], first: int, separator: str, width: int
) -> list[str] | None:
    """Names in the last comment above the rows that has as many cells as they have."""
    for number, line in reversed(comments):
        if number > first:
            continue
        text = line.strip().lstrip("#%/").strip()
        names = split_lines([(number, text)], separator)
        if names and len(names[0].cells) == width and not any(map(is_value, names[0].cells)):
            return names[0].cells
    return None


def _refuse_unclear(row: Line, separator: str) -> None:
    """A first line that may be names or numbers, or numbers cut apart at their decimal comma, is refused."""
    cells = row.cells
    integers = [int(cell) for cell in cells if cell.isascii() and cell.isdigit()]
    if len(integers) == len(cells) and integers in ([*range(len(cells))], [*range(1, len(cells) + 1)]):
        raise ValueError(
            f"line {row.number}: got {','.join(cells)!r}, which may be names or numbers, expected a header"
        )
    if separator == "," and any(re.fullmatch(r"0\d+", cell) for cell in cells):
        raise ValueError(
            f"line {row.number}: got {','.join(cells)!r}, whose commas may be decimal, expected a header, "
            "or ';' between cells"
        )

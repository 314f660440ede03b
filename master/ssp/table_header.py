"""The header of a table in an archive: which column has the times."""

from __future__ import annotations

import csv
import io

from master.recording.time_column import time_name

_MOST_BYTES = 2**20  # of the first line


def time_column(content: bytes) -> str:
    """
    Name the column of times of a CSV: `time` or `t` in any spelling, else the first.

    Raises:
        ValueError: If there is no header.
    """
    text = content[:_MOST_BYTES].decode("utf-8-sig", "replace")
    first = text.splitlines()[:1]
    try:
        names = [name.strip() for name in next(csv.reader(io.StringIO("".join(first))), [])]
    except csv.Error as error:
        raise ValueError(f"not a table, {error}") from None
    if not names:
        raise ValueError("the file is empty, expected a header with names of columns")
    return time_name(names)

"""Dates and times of day as ISO 8601 writes them, to the nanosecond."""

from __future__ import annotations

import re
from collections.abc import Sequence
from datetime import UTC, datetime

import numpy as np
from numpy.typing import NDArray

_ISO = re.compile(
    r"(?:(?P<date>\d{4}-\d\d-\d\d)[T ])?(?P<time>\d\d:\d\d:\d\d)(?:[.,](?P<part>\d{1,9}))?"
    r"\s?(?P<zone>Z|[+-]\d\d:?\d\d)?"
)


def is_instant(cell: str) -> bool:
    """Return whether a text is a date with a time, or a time of day."""
    return _ISO.fullmatch(cell.strip()) is not None


def instants(cells: Sequence[object]) -> NDArray[np.datetime64] | None:
    """Return instants, shape (n,); None if a cell is none, or only some have a date or a zone."""
    matches = [_ISO.fullmatch(cell.strip()) if isinstance(cell, str) else None for cell in cells]
    found = [match for match in matches if match is not None]
    forms = {(match["date"] is None, match["zone"] is None) for match in found}
    if len(found) < len(matches) or len(forms) != 1:
        return None
    try:
        return np.array([_instant(match) for match in found], dtype="datetime64[ns]")
    except ValueError:  # the 31st of February
        return None


def _instant(match: re.Match[str]) -> np.datetime64:
    given = datetime.fromisoformat(f"{match['date'] or '1970-01-01'}T{match['time']}{match['zone'] or ''}")
    if given.tzinfo is not None:
        given = given.astimezone(UTC).replace(tzinfo=None)
    part = int((match["part"] or "").ljust(9, "0"))
    return np.datetime64(given, "ns") + np.timedelta64(part, "ns")

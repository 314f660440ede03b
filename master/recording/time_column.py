"""Which column of a table has the times."""

from __future__ import annotations

from collections.abc import Sequence


def time_name(names: Sequence[str]) -> str:
    """Return the name of the column of times: `time` or `t` in any spelling, else the first."""
    return next((name for name in names if name.lower() in ("time", "t")), names[0])

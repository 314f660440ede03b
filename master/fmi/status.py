"""The statuses that functions of FMI return."""

from __future__ import annotations

from enum import IntEnum


class Status(IntEnum):
    """Status of a call, numbered as in FMI 2.0; FMI 3.0 has no PENDING."""

    OK = 0
    WARNING = 1
    DISCARD = 2
    ERROR = 3
    FATAL = 4
    PENDING = 5


def status_name(status: int) -> str:
    """Return the name of a status in lower case; `status 77` for a number that FMI does not define."""
    try:
        return Status(status).name.lower()
    except ValueError:
        return f"status {status}"


_MEANING = {
    Status.DISCARD: ": it cannot do this",
    Status.PENDING: ": a step in the background, which the master does not wait for",
}


def described(status: int) -> str:
    """Name a status, and say what it means where the name does not."""
    try:
        known = Status(status)
    except ValueError:
        return f"status {status}, which FMI does not define, expected 0 to 5"
    return f"status {status_name(status)}{_MEANING.get(known, '')}"

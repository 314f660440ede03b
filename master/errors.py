"""
What a user of the master may be told.

    MasterError            exit 2
      ConfigError          the input is wrong; carries every problem found
      DataError            a recording or a result file is wrong
      FmuError      exit 3 an FMU failed; carries instance, time and status

A run that diverges is no error: its status is `diverged` and its exit status 4. Neither is one that
`stop_when` ends: `stopped`, 5; nor are runs that differ (`compare`, `rerun`): exit status 1.
"""

from __future__ import annotations

import functools
import re
from collections.abc import Iterable
from difflib import get_close_matches
from pathlib import PurePath
from typing import Any

EXIT_DIFFERENT = 1
EXIT_INPUT = 2
EXIT_FMU = 3
EXIT_DIVERGED = 4
EXIT_STOPPED = 5

_LONGEST_SHOWN = 120
_LONGEST_PART = 600
_MOST_NAMES = 30
_PLACE = re.compile(
    r"(?P<where>.*?:\d+: \S+|-{2}[\w-]+(?: \S+)?|[\w./-]+(?:\[\d+\])*): (?P<what>.*)", re.DOTALL
)


class Problem(str):
    """
    One fault of an input: the line that a user reads, with its parts as attributes.

    Args:
        what: What is wrong.
        where: Place in the input, as `file:line: key` or `--option`; empty where none is known.
        got: What the input holds, as it is shown.
        expected: What belongs there.
    """

    what: str
    where: str
    got: str
    expected: str

    def __new__(cls, what: str, *, where: str = "", got: str = "", expected: str = "") -> Problem:
        """Join the parts to the line; parts that are too long to read are cut."""
        what = _cut(what, _LONGEST_PART)
        got = _cut(got, _LONGEST_PART)
        line = f"{where}: {what}" if where else what
        line += f", got {got}" if got else ""
        line += f", expected {expected}" if expected else ""
        self = super().__new__(cls, line)
        self.what = what
        self.where = where
        self.got = got
        self.expected = expected
        return self

    @classmethod
    def of_line(cls, line: str) -> Problem:
        """Split a line of the form `where: what, got ..., expected ...`."""
        if isinstance(line, Problem):
            return line
        place = _PLACE.fullmatch(line)
        where = "" if place is None else place["where"]
        rest = line if place is None else place["what"]
        head, _, tail = rest.partition(", expected ")
        what, _, got = head.partition(", got ")
        return cls(what, where=where, got=got, expected=tail)

    def at(self, where: str) -> Problem:
        """Return the same fault within a larger place."""
        inner = f"{where}: {self.where}" if self.where else where
        return Problem(self.what, where=inner, got=self.got, expected=self.expected)

    def as_dict(self) -> dict[str, str]:
        """Parts by name, for JSON."""
        return {"where": self.where, "what": self.what, "got": self.got, "expected": self.expected}


class MasterError(Exception):
    """Base of all that a user of the master may see."""

    exit_status = EXIT_INPUT


class ConfigError(MasterError):
    """An input with faults: `problems` holds each of them once, in order."""

    def __init__(self, problems: Iterable[str]) -> None:
        self.problems = [Problem.of_line(line) for line in dict.fromkeys(problems)]
        super().__init__("\n".join(self.problems))

    def __reduce__(self) -> tuple[type[ConfigError], tuple[list[Problem]]]:
        """Keep the list when the error goes from one process to another."""
        return type(self), (self.problems,)


class DataError(MasterError):
    """A file of measured or computed values that cannot be used."""


class FmuError(MasterError):
    """An FMU that answered with a status worse than warning, or could not be loaded."""

    exit_status = EXIT_FMU

    def __init__(
        self, instance: str, message: str, *, time: float | None = None, status: str = "error"
    ) -> None:
        self.instance = instance
        self.time = time
        self.status = status
        self.message = message
        place = instance if time is None else f"{instance} at t={time:.15g} s"
        super().__init__(f"{place}: {message}")

    def __reduce__(self) -> Any:  # an FMU may fail in a process of its own
        make = functools.partial(FmuError, time=self.time, status=self.status)
        return make, (self.instance, self.message)


def closest(name: str, existing: Iterable[str]) -> str | None:
    """Return the existing name that is most like another; None if none is."""
    return next(iter(get_close_matches(name[:_LONGEST_SHOWN], list(existing), n=1)), None)


def nearest(name: str, existing: Iterable[str]) -> str:
    """Say what exists, the nearest name first: `'a' (of a, b, c)` or `one of a, b, c`."""
    names = [readable(one) for one in existing]
    near = closest(name, names)
    listed = ", ".join(names[:_MOST_NAMES]) + (", ..." if len(names) > _MOST_NAMES else "")
    return f"{near!r} (of {listed})" if near else f"one of {listed or 'none'}"


def expected(name: str, existing: Iterable[str]) -> str:
    """Say what exists, as the end of a message: `expected 'a' (of a, b, c)`."""
    return f"expected {nearest(name, existing)}"


def shown(value: Any) -> str:
    """Return a value as a message shows it: text in quotes, long values cut, `nothing` for None."""
    if value is None:
        return "nothing"
    if isinstance(value, PurePath):
        return readable(str(value))
    if isinstance(value, dict):
        return "a mapping" if value else "an empty mapping"
    if isinstance(value, list | tuple):
        return (
            "a list"
            if len(value) > _MOST_NAMES or any(isinstance(v, list | dict) for v in value)
            else _cut(_listed(value))
        )
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, int) and abs(value) >= 10**_LONGEST_SHOWN:
        return "an integer of more than 120 digits"
    text = value.shown if hasattr(value, "shown") else repr(value)
    return _cut(str(text))


def _listed(values: list[Any] | tuple[Any, ...]) -> str:
    return "[" + ", ".join(map(shown, values)) + "]"


def _cut(text: str, longest: int = _LONGEST_SHOWN) -> str:
    if len(text) <= longest:
        return text
    return f"{text[: longest // 2]}... ({len(text)} characters)"


def readable(name: str) -> str:
    """Return a name as it can be shown: without control characters, and cut if it is long."""
    return _cut(name if name.isprintable() else repr(name)[1:-1])

"""
What a user of the master may be told.

    MasterError            exit 2
      ConfigError          the input is wrong; carries every problem found
      DataError            a recording or a result file is wrong
      FmuError      exit 3 an FMU failed; carries instance, time and status
    Divergence             not an error: a run's status, exit 4
"""

from __future__ import annotations

import functools
from collections.abc import Iterable
from difflib import get_close_matches
from typing import Any

EXIT_DONE = 0
EXIT_INPUT = 2
EXIT_FMU = 3
EXIT_DIVERGED = 4


class MasterError(Exception):
    """Base of all that a user of the master may see."""

    exit_status = EXIT_INPUT


class ConfigError(MasterError):
    """A system description with faults; `problems` holds one line each."""

    def __init__(self, problems: Iterable[str]) -> None:
        self.problems = list(problems)
        super().__init__("\n".join(self.problems))


class DataError(MasterError):
    """A file of measured or computed values that cannot be used."""


class FmuError(MasterError):
    """An FMU that answered with a status worse than warning, or could not be loaded."""

    exit_status = EXIT_FMU

    def __init__(
        self, instance: str, message: str, *, time: float | None = None, status: str = "error"
    ) -> None:
        self.instance, self.time, self.status = instance, time, status
        self.message = message
        place = instance if time is None else f"{instance} at t={time:.9g} s"
        super().__init__(f"{place}: {message}")

    def __reduce__(self) -> Any:  # an FMU may fail in a process of its own
        make = functools.partial(FmuError, time=self.time, status=self.status)
        return make, (self.instance, self.message)


def expected(name: str, existing: Iterable[str]) -> str:
    """Say what exists, the nearest names first: `expected 'a' (or one of ...)`."""
    names = list(existing)
    near = get_close_matches(name, names, n=1)
    listed = ", ".join(names[:30]) + (", ..." if len(names) > 30 else "")
    hint = f"{near[0]!r} (of {listed})" if near else f"one of {listed or 'none'}"
    return f"expected {hint}"

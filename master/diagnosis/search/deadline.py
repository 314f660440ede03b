"""A diagnosis that has to end, by a budget of time."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, field


class TimeIsUpError(Exception):
    """The search of a part ends here, with the best so far."""


@dataclass
class Deadline:
    """
    When to stop searching.

    `budget` is in seconds from now, None for no end. Each part that is searched after the end is stopped at
    its first step; what must be done to report the best so far is not.
    """

    budget: float | None = None
    begun: float = field(default_factory=time.monotonic)
    is_armed: bool = False
    has_stopped: bool = False

    def arm(self) -> None:
        """A part begins that may be stopped."""
        self.is_armed = True

    def disarm(self) -> None:
        """What follows is needed for the report."""
        self.is_armed = False

    def watched(self, progress: Callable[[str], None]) -> Callable[[str], None]:
        """Return a progress that stops the search once the time is up."""

        def show(text: str) -> None:
            progress(text)
            is_over = self.budget is not None and time.monotonic() - self.begun > self.budget
            if self.is_armed and is_over:
                self.disarm()
                self.has_stopped = True
                raise TimeIsUpError

        return show

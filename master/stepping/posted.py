"""Snapshots handed by the process that steps to the one that saves them."""

from __future__ import annotations

import time
from dataclasses import dataclass

from master.errors import FmuError
from master.process.mailbox import Mailbox

from .snapshot import Snapshot


@dataclass(frozen=True)
class Posted:
    """The bytes of a snapshot, and its tick."""

    tick: int
    data: bytes


class PostedSnapshots:
    """
    A place for one snapshot in memory that both processes share: `Checkpoints` for the run.

    The first one is due at once, so that an FMU that cannot hand over its state fails at the start; each
    further one after an interval [s], if the one before it has been taken.
    """

    def __init__(self, interval: float) -> None:
        self._interval = interval
        self._mailbox = Mailbox()
        self._last = -float("inf")

    def is_due(self) -> bool:
        return time.monotonic() - self._last >= self._interval and self._mailbox.is_empty()

    def put(self, snapshot: Snapshot) -> None:
        """Post it, or nothing where the one before it has not been taken yet; FmuError if it is too large."""
        if not self._mailbox.is_empty():
            return
        data = snapshot.to_bytes()
        if len(data) > self._mailbox.most_bytes // 2:
            largest = max(snapshot.fmus, key=lambda name: len(snapshot.fmus[name]))
            got = f"{len(snapshot.fmus[largest])} bytes"
            raise FmuError(largest, f"its state is too large for a checkpoint, got {got}")
        self._last = time.monotonic()
        self._mailbox.put(Posted(snapshot.tick, data))

    def take(self) -> Posted | None:
        """In the process that saves: take what was posted."""
        posted = self._mailbox.take()
        return posted if isinstance(posted, Posted) else None

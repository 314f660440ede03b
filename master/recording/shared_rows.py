"""Rows of a run in memory that two processes share: one computes them, the other saves them."""

from __future__ import annotations

import mmap
import time

import numpy as np
from numpy.typing import NDArray

from master.process.memory import room, shared_memory
from master.process.position import CONSUMED, STAGE, STEPPING, TICK, WRITTEN, Position

from .recorder import Result

Floats = NDArray[np.float64]

_RING_BYTES = 2**26
_FEWEST_ROWS = 1024
_BYTES_TAKEN = 2**18
_ROWS_TAKEN = 128  # of a wide system, where taking costs more than a few rows
_MOST_BYTES_TAKEN = 2**22
_WAIT_SECONDS = 1e-3


class SharedRows:
    """
    All rows of a run, or with `is_ring` as many as fit into some memory until they are taken.

    The run writes through `room` and `add`, as to a `Recorder`; the other process takes them by `take`.
    """

    def __init__(self, position: Position, n_signals: int, n_rows: int, *, is_ring: bool) -> None:
        n_bytes = 8 * max(1, n_signals)
        self.capacity = min(n_rows, max(_FEWEST_ROWS, room(_RING_BYTES) // n_bytes)) if is_ring else n_rows
        self._is_ring = is_ring
        self._cells = position.cells
        memory = shared_memory(self.capacity * n_bytes)
        self._cells_of_rows = np.frombuffer(memory, np.float64, self.capacity * n_signals)
        self._table = self._cells_of_rows.reshape(self.capacity, n_signals)

    def touch(self) -> None:
        """
        Let this process have all pages of a ring before rows come: a long run takes no more memory later.

        A process that is forked has to do it again.
        """
        if self._is_ring:
            self._cells_of_rows[:: mmap.PAGESIZE // 8] = 0.0

    def go_on(self, n_rows: int) -> None:
        """Go on after rows that were taken in another process."""
        self._cells[WRITTEN] = self._cells[CONSUMED] = n_rows

    def most(self, wanted: int) -> int:
        """Return how many rows there is room for, at most as wanted; waits for the first one."""
        written = int(self._cells[WRITTEN])
        until_end = self.capacity - written % self.capacity
        if not self._is_ring:
            return min(wanted, until_end)
        while (free := self.capacity - (written - int(self._cells[CONSUMED]))) == 0:
            time.sleep(_WAIT_SECONDS)
        return min(wanted, until_end, free, max(1, self.capacity // 4))

    def room(self, n: int) -> Floats:
        """Rows to be filled and then added, shape (n, signals)."""
        first = int(self._cells[WRITTEN]) % self.capacity
        return self._table[first : first + n]

    def ahead(self, n: int) -> Floats:
        return self.room(n)

    def add(self, rows: Floats) -> None:
        """Append rows, shape (n, signals)."""
        place = self.room(len(rows))
        if not np.may_share_memory(place, rows):
            place[:] = rows
        self._cells[WRITTEN] += len(rows)

    def result(self) -> Result:
        """No rows: the other process has them."""
        return Result(np.empty(0), (), (), np.empty((0, 0)))

    def n_complete(self) -> int:
        """Number of rows that are complete though the run may have ended amid the ones it has room for."""
        in_room = int(self._cells[TICK]) + 1 if self._cells[STAGE] == STEPPING else 0
        return max(int(self._cells[WRITTEN]), in_room)

    def take(self, end: int) -> Floats:
        """
        Return rows not taken before, up to `end` at most, as a copy; shape (n, signals).

        A small piece at a time: what takes them needs the same memory however far it is behind. Pieces of
        megabytes would leave the heap with gaps between what is kept, more of them the longer a run takes.
        """
        begin = int(self._cells[CONSUMED])
        first = begin % self.capacity
        n_bytes = 8 * max(1, self._table.shape[1])
        most = max(1, _BYTES_TAKEN // n_bytes, min(_ROWS_TAKEN, _MOST_BYTES_TAKEN // n_bytes))
        rows = self._table[first : first + min(end - begin, self.capacity - first, most)].copy()
        self._cells[CONSUMED] = begin + len(rows)
        return rows

    def all(self, end: int) -> Floats:
        """Return the first `end` rows of a table that holds all, shape (end, signals)."""
        return self._table[:end]

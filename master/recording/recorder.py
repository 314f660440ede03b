"""Rows of values as they are computed: row k holds the values at t0 + k h, row 0 the initial ones."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Protocol

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from master.system.graph import Port

Floats = NDArray[np.float64]

_FIRST_BYTES = 2**28  # of address space; the system gives memory only where rows are written


@dataclass(frozen=True)
class Result:
    """Recorded signals of a run: `values` has shape (rows, signals), `time` [s] has shape (rows,)."""

    time: Floats
    names: tuple[str, ...]
    units: tuple[str, ...]
    values: Floats

    def __getitem__(self, name: str) -> Floats:
        """One signal, shape (rows,); KeyError if it was not recorded."""
        try:
            return self.values[:, self.names.index(name)]
        except ValueError:
            raise KeyError(name) from None

    def unit(self, name: str) -> str:
        """Unit of a signal."""
        return self.units[self.names.index(name)]


class Sink(Protocol):
    """Takes rows while a run goes on, so that they need not stay in memory."""

    def write(self, result: Result) -> None:
        """Write rows that follow those written before."""
        ...


class Rows(Protocol):
    """What a run fills with rows."""

    def most(self, wanted: int) -> int:
        """Return how many rows there is room for now, at least 1 and at most as wanted."""
        ...

    def room(self, n: int) -> Floats:
        """Rows to be filled and then added, shape (n, signals)."""
        ...

    def ahead(self, n: int) -> Floats:
        """Memory of the next n rows, as far as there is any: shape (at most n, signals)."""
        ...

    def add(self, rows: Floats) -> None:
        """Append rows, shape (n, signals)."""
        ...

    def result(self) -> Result:
        """All rows that were kept."""
        ...


@dataclass
class Recorder:
    """
    Collects rows in one table, which grows up to `most_rows`.

    With a sink, all rows go there and only every `keep_every`-th one stays in memory.
    """

    ports: Sequence[Port]
    t0: float
    step_size: float
    keep_every: int = 1
    sink: Sink | None = None
    most_rows: int = 1
    n_rows: int = 0
    _n_kept: int = field(default=0, init=False)
    _table: Floats = field(init=False)

    def __post_init__(self) -> None:
        self._table = np.empty((0, len(self.ports)))

    def reserve(self) -> None:
        """Take the memory of all rows that will be kept, so that a long run does not grow."""
        self._grow(-(-self.most_rows // self.keep_every))
        self._table[self._n_kept :] = 0.0

    def most(self, wanted: int) -> int:
        return wanted

    def room(self, n: int) -> Floats:
        """Rows to be filled and then added, shape (n, signals): in the table itself where all are kept."""
        if self.keep_every > 1:
            return np.empty((n, len(self.ports)))
        self._grow(self._n_kept + n)
        return self._table[self._n_kept : self._n_kept + n]

    def ahead(self, n: int) -> Floats:
        return self.room(n)

    def add(self, rows: Floats) -> None:
        """Append rows, shape (n, signals)."""
        first = self.n_rows
        self.n_rows += len(rows)
        if self.sink is not None:
            self.sink.write(self._result(np.arange(first, self.n_rows), rows))
        kept = rows[-first % self.keep_every :: self.keep_every]
        self._grow(self._n_kept + len(kept))
        place = self._table[self._n_kept : self._n_kept + len(kept)]
        if not np.may_share_memory(place, kept):
            place[:] = kept
        self._n_kept += len(kept)

    def result(self) -> Result:
        """All rows that were kept."""
        return self._result(self.keep_every * np.arange(self._n_kept), self._table[: self._n_kept])

    def cut(self, n: int) -> None:
        """Forget all rows after the first n, where all are kept."""
        assert self.keep_every == 1, "rows between were not kept"
        self.n_rows = n
        self._n_kept = n

    @property
    def kept(self) -> Floats:
        """Rows in memory, shape (n, signals)."""
        return self._table[: self._n_kept]

    def go_on(self, n_rows: int, kept: Floats) -> None:
        """Go on after `n_rows` rows that another process recorded, of which `kept` stay in memory."""
        self.n_rows = n_rows
        self._n_kept = 0
        self._grow(len(kept))
        self._table[: len(kept)] = kept
        self._n_kept = len(kept)

    def as_result(self, rows: Floats) -> Result:
        """Return rows collected elsewhere from the first one on, shape (n, signals), as a result."""
        return self._result(np.arange(len(rows)), rows)

    def _grow(self, n: int) -> None:
        if n > len(self._table):
            most = -(-self.most_rows // self.keep_every)
            first = _FIRST_BYTES // (8 * max(1, len(self.ports)))
            larger = np.empty((max(n, min(most, max(first, 2 * n))), len(self.ports)))
            larger[: self._n_kept] = self._table[: self._n_kept]
            self._table = larger

    def _result(self, rows: NDArray[np.int64], values: Floats) -> Result:
        names = tuple(p.name for p in self.ports)
        units = tuple(p.variable.unit_name for p in self.ports)
        time = self.t0 + rows.astype(np.float64) * self.step_size
        return Result(time, names, units, values)

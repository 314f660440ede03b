"""What of a run goes to its files: some signals, every n-th row."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from .recorder import Result, Sink


@dataclass(frozen=True)
class Selection:
    """Signals by name, all of them where none is named; rows 0, n, 2n, ... of the run for `every` n."""

    signals: tuple[str, ...] = ()
    every: int = 1

    @property
    def is_all(self) -> bool:
        """Whether nothing is left out."""
        return not self.signals and self.every == 1

    def of(self, result: Result, first_row: int = 0) -> Result:
        """Select from rows of a run; `first_row` is the number in the run of the first of them."""
        if self.is_all:
            return result
        names = self.signals or result.names
        columns = [result.names.index(name) for name in names]
        rows = slice(-first_row % self.every, None, self.every)
        units = tuple(result.units[column] for column in columns)
        values = result.values[rows][:, columns]
        return replace(result, time=result.time[rows], names=names, units=units, values=values)


class SelectedRows:
    """A sink that passes on what is selected, from row `first_row` of the run on."""

    def __init__(self, selection: Selection, sink: Sink, first_row: int = 0) -> None:
        self._selection = selection
        self._sink = sink
        self._n_rows = first_row

    def write(self, result: Result) -> None:
        """Take rows that follow those written before."""
        chosen = self._selection.of(result, self._n_rows)
        self._n_rows += len(result.time)
        if len(chosen.time):
            self._sink.write(chosen)

"""The samples of a recording at the ticks of a run, and every fault of its times and columns."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from master.errors import DataError, expected
from master.fmi.unit_names import unit as unit_named
from master.fmi.units import Conversion
from master.recording.tables import Table, read_table

from .config import InputFile, LoadedConfig, MeasuredColumn
from .grid import SHARE_OF_A_TICK, Grid

Floats = NDArray[np.float64]

_COARSEST = 0.25  # of a tick: how far a time may be off by the digits it is stored with


class InputReader:
    """The samples of one file, `path`, at the ticks of the run."""

    def __init__(
        self, loaded: LoadedConfig, i: int, given: InputFile, grid: Grid, problems: list[str]
    ) -> None:
        self._given = given
        self._problems = problems
        self._grid = grid
        self.path = loaded.files.get(given.file, loaded.folder / given.file)
        self._shown = given.file if given.file in loaded.files else str(self.path)
        self._table = self._read(loaded.where("inputs", i, "file"))
        self._ticks = None if self._table is None else self._sample_ticks(self._table, loaded, i)

    def column(self, column: MeasuredColumn, where: str) -> Floats | None:
        """Return a column at all ticks, shape (ticks + 1,), None if something is wrong with it."""
        values = None if self._table is None else self._numbers(self._table, column.column, where)
        if values is None or self._ticks is None:
            return None
        if len(values) != len(self._ticks):
            got = f"{len(values)} values, expected {len(self._ticks)} as in the column of the time"
            self._problems.append(f"{where}: {self._shown}: column {column.column!r}: got {got}")
            return None
        at = np.arange(self._grid.n_ticks + 1, dtype=np.float64)
        if np.array_equal(self._ticks[: len(at)], at):
            return values[: len(at)]
        if self._given.interpolation == "linear":
            return np.interp(at, self._ticks, values)
        return values[np.searchsorted(np.ceil(self._ticks), at, side="right") - 1]

    def _read(self, where: str) -> Table | None:
        try:
            return read_table(self.path, self._given.array)
        except DataError as error:
            said = str(error).replace(str(self.path), self._shown)
            self._problems += [f"{where}: {line}" for line in said.splitlines()]
            return None

    def _numbers(self, table: Table, name: str, where: str) -> Floats | None:
        if name not in table.columns:
            known = expected(name, table.columns)
            self._problems.append(f"{where}: {self._shown}: no such column, got {name!r}, {known}")
            return None
        faults = [*table.faults.get("", []), *table.faults.get(name, [])]
        faults = faults or list(_not_finite(table, name))
        self._problems += [f"{where}: {f.replace(str(table.path), self._shown)}" for f in faults]
        return None if faults else table.columns[name]

    def _sample_ticks(self, table: Table, loaded: LoadedConfig, i: int) -> Floats | None:
        """Ticks of the samples, integers where a sample is meant to be at a tick; None if they are wrong."""
        where = loaded.where("inputs", i, "time", "column")
        times = self._numbers(table, self._given.time.column, where)
        factor = _seconds(self._given.time, loaded.where("inputs", i, "time", "unit"), self._problems)
        if times is None or factor is None:
            return None
        faults = list(self._time_faults(table, times, factor))
        self._problems += [f"{where}: {self._shown}: {fault}" for fault in faults]
        return None if faults else self._snapped(times, factor)

    def _snapped(self, times: Floats, factor: float) -> Floats:
        ticks = (times * factor - self._grid.t0) / self._grid.step_size
        nearest = np.rint(ticks)
        tolerance = float(SHARE_OF_A_TICK) + self._rounding(times, factor)
        return np.where(np.abs(ticks - nearest) <= tolerance, nearest, ticks)

    def _rounding(self, times: Floats, factor: float) -> float:
        """Largest error of a time in ticks, by the digits that a double has."""
        largest = max(float(np.max(np.abs(times))) * factor, abs(self._grid.t0))
        return 4.0 * float(np.spacing(largest)) / self._grid.step_size

    def _time_faults(self, table: Table, times: Floats, factor: float) -> Iterator[str]:
        unit = self._given.time.unit or "s"
        if not len(times):
            yield "no samples, expected at least one"
            return
        back = np.flatnonzero(np.diff(times) <= 0.0)
        if len(back):
            row = back[0] + 1
            got = f"time goes from {times[row - 1]:.9g} to {times[row]:.9g} {unit}"
            yield f"row {row + table.first_row}: {got}, expected it to grow"
            return
        if self._rounding(times, factor) > _COARSEST:
            step = f"steps of {self._grid.step_size:g} s"
            yield f"times up to {times[-1]:.9g} {unit} have too few digits, expected enough for {step}"
            return
        ticks = self._snapped(times, factor)
        if ticks[0] > 0.0:
            begin = f"{self._grid.t0:.9g} s"
            yield f"begins at {times[0] * factor:.9g} s, expected a sample at or before the start, {begin}"
        if self._given.interpolation == "linear" and ticks[-1] < self._grid.n_ticks:
            end = f"{self._grid.time(self._grid.n_ticks):.9g} s"
            yield f"ends at {times[-1] * factor:.9g} s, expected a sample at or after the stop, {end}"


def converted(change: Conversion, values: Floats) -> Floats:
    """Convert values as a wire converts each."""
    found = values
    for key, value in change.table:
        found = np.where(values == key, value, found)
    return change.factor * found + change.offset if change.is_scaled else found


def later(ticks: int, values: Floats) -> Floats:
    """Let values act some ticks later; the first one until then."""
    at = np.maximum(np.arange(len(values)) - ticks, 0)
    return values[at] if ticks else values


def _not_finite(table: Table, name: str) -> Iterator[str]:
    bad = np.flatnonzero(~np.isfinite(table.columns[name]))
    if len(bad):
        value = table.columns[name][bad[0]]
        more = f" (and {len(bad) - 1} more)" if len(bad) > 1 else ""
        row = bad[0] + table.first_row
        yield f"{table.path}: row {row}, column {name!r}: got {value}, expected a number{more}"


def _seconds(column: MeasuredColumn, where: str, problems: list[str]) -> float | None:
    """Return the factor from the unit of a time to seconds."""
    try:
        found = unit_named(column.unit or "s")
    except ValueError as error:
        problems.append(f"{where}: {error}")
        return None
    if found.exponents != {"s": 1}:
        problems.append(f"{where}: not a time, got {column.unit!r}, expected s, ms, ...")
        return None
    return found.factor

"""Recordings: columns of a file as signals in SI units on an even time grid, or all faults at once."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from master.diagnosis.numerics.arrays import Array
from master.errors import DataError
from master.fmi.unit_names import unit
from master.recording.tables import Table, read_table, shortened

from .clock import ClockRules, clock_of, coarsest_print
from .counts import signed, unwrapped, wrap_of
from .resample import Method, resampled

FEWEST_SAMPLES = 200  # of a recording: below, no part of it says anything
SAME_INSTANT = 0.01  # of a step: how far apart the same instant may be stamped by two clocks
FEWEST_OF_PIECE = 100  # between two gaps: shorter pieces are left out
LEAST_RATE = 0.5  # slope of a rate's integral over its signal: no two units differ by so little
LARGEST_RATE = 2.0
CLOCK = "(time of the row)"  # name of a column that is made where there is none


@dataclass(frozen=True)
class Column:
    """
    How a column becomes a signal: sign * scale * column, from `unit` to SI, minus `offset` [SI].

    `bits` is the width of a counter in two's complement; `wraps` is the range that it, or an angle, is
    followed over the ends of, in the unit of the column.
    """

    column: str
    unit: str
    scale: float = 1.0
    sign: int = 1
    offset: float = 0.0
    bits: int | None = None
    wraps: float | None = None


@dataclass(frozen=True)
class Rules:
    """
    What a recording must keep.

    `clock` are the rules of its times. `rates` maps a signal to the one that is its time derivative.
    """

    fewest: int = FEWEST_SAMPLES
    clock: ClockRules = field(default_factory=ClockRules)
    rates: Mapping[str, str] = field(default_factory=dict)


@dataclass(frozen=True)
class Recording:
    """
    Signals in SI units, shape (n,) each, at times t [s] with the period [s].

    `entry` is the recording of the case that it is a piece of, `notes` what was done to how many of its rows,
    `given` the values `fmu.variable` that hold for it alone.
    """

    name: str
    t: Array
    signals: Mapping[str, Array]
    period: float
    entry: str = ""
    notes: tuple[str, ...] = ()
    given: Mapping[str, float] = field(default_factory=dict)

    def __len__(self) -> int:
        return len(self.t)

    def __getitem__(self, signal: str) -> Array:
        return self.signals[signal]


@dataclass(frozen=True)
class Rows:
    """
    Signals in SI units at times t [s] of a clock, shape (n,) each, in `pieces` (begin, end) between gaps.

    `period` [s] is the mean step, `notes` say what was done to how many rows.
    """

    t: Array
    pieces: tuple[tuple[int, int], ...]
    period: float
    signals: Mapping[str, Array]
    notes: tuple[str, ...] = ()


def read(
    path: str | Path,
    time: Column | None,
    columns: Mapping[str, Column],
    *,
    rules: Rules | None = None,
    array: str | None = None,
) -> Recording:
    """
    Read the whole of a recording without gaps; the arguments are those of `read_rows`.

    Raises:
        DataError: With every fault, row and column.
    """
    found = read_rows(path, time, columns, rules=rules, array=array)
    return Recording(array or Path(path).stem, found.t, found.signals, found.period, notes=found.notes)


def read_rows(
    path: str | Path,
    time: Column | None,
    columns: Mapping[str, Column],
    *,
    rules: Rules | None = None,
    array: str | None = None,
    rows: tuple[int, int] | None = None,
) -> Rows:
    """
    Read the rows of a file; nothing is resampled, filled or cut.

    Args:
        path: File of a format in `master.recording.tables.FORMATS`.
        time: Column of the time; None: rows are `rules.clock.period` apart.
        columns: Signal to column.
        rules: What the recording must keep.
        array: Name of a two-dimensional array in an NPZ, MAT or HDF5.
        rows: First row to take, and the first not to take.

    Raises:
        DataError: With every fault, row and column.
    """
    rules = rules or Rules()
    where = f"{path}" if array is None else f"{path}[{array}]"
    table = _cut(read_table(path, array), rows, where)
    time = time or _clock(table, rules)
    sources = {"time": time, **columns}
    problems = [
        *_missing(table, sources, where),
        *_units(table, sources, where),
        *(_other_clocks(table, sources, where) or _lengths(table, sources, where)),
        *_cells(table, sources, where),
    ]
    if problems:
        raise DataError("\n".join(problems))
    notes = list(table.notes)
    signals: dict[str, Array] = {}
    for name, column in sources.items():
        values = _counted(table.columns[column.column], column, where, notes, problems)
        signals[name] = _signal(values, column)
    t = signals.pop("time")
    if len(t) < max(rules.fewest, 3):
        problems.append(f"{where}: too few samples, got {len(t)}, expected at least {rules.fewest}")
    if problems:
        raise DataError("\n".join(problems))
    printed = coarsest_print(table.columns[time.column]) if time.column not in table.dates else None
    if printed is not None:
        printed = np.abs(time.scale) * unit(time.unit).factor * printed
    clock = clock_of(t, printed, rules.clock, where, table.first_row)
    pieces = [slice(begin, end) for begin, end in clock.pieces]
    problems += clock.problems
    for piece in pieces:
        problems += _rate_faults(clock.t[piece], {n: v[piece] for n, v in signals.items()}, rules, where)
    if problems:
        raise DataError("\n".join(dict.fromkeys(problems)))
    return Rows(clock.t, clock.pieces, clock.period, signals, (*notes, *clock.notes))


def pieces_of(
    rows: Rows, name: str, where: str, *, period: float | None = None, method: Method | None = None
) -> list[Recording]:
    """
    Cut rows at their gaps into recordings, resampled where a method is given.

    Args:
        rows: What was read.
        name: Name of the recording; pieces are called `name[1]`, `name[2]`, ...
        where: File, for what is wrong.
        period: Distance of new rows [s]; None: the mean of the old ones.
        method: How rows are resampled; None: they stay.

    Raises:
        DataError: If no piece is long enough.
    """
    pieces = []
    n_short = 0
    notes: list[str] = []
    for begin, end in rows.pieces:
        t = rows.t[begin:end]
        signals: Mapping[str, Array] = {n: v[begin:end] for n, v in rows.signals.items()}
        if len(t) < FEWEST_OF_PIECE:
            n_short += len(t)
            continue
        distance = rows.period if method is None else period or rows.period
        if method is not None:
            made = resampled(t, signals, distance, method)
            t = made.t
            signals = made.signals
            notes.append(made.note)
        pieces.append(Recording(name, t, signals, distance, entry=name))
    if n_short:
        notes.append(f"left out: {n_short} rows of pieces with fewer than {FEWEST_OF_PIECE} between gaps")
    if not pieces:
        longest = max((end - begin for begin, end in rows.pieces), default=0)
        raise DataError(
            f"{where}: got no piece between gaps of more than {longest} rows, "
            f"expected {FEWEST_OF_PIECE} or more"
        )
    told = (*rows.notes, *notes)
    if len(pieces) == 1:
        return [replace(pieces[0], notes=told)]
    return [
        replace(piece, name=f"{name}[{i}]", notes=told if i == 1 else ())
        for i, piece in enumerate(pieces, start=1)
    ]


def _cut(table: Table, rows: tuple[int, int] | None, where: str) -> Table:
    if rows is not None:
        longest = max((len(values) for values in table.columns.values()), default=0)
        if not 0 <= rows[0] < rows[1] <= longest:
            raise DataError(f"{where}: rows, got {list(rows)}, expected some of its {longest}")
        table.columns = {name: np.array(v[rows[0] : rows[1]]) for name, v in table.columns.items()}
        table.first_row += rows[0]
    return table


def _clock(table: Table, rules: Rules) -> Column:
    """Add a column of times where the recording has none."""
    if rules.clock.period is None:
        raise DataError(f"{table.path}: no time, expected a column or a period")
    longest = max((len(values) for values in table.columns.values()), default=0)
    table.columns[CLOCK] = np.asarray(np.arange(longest) * rules.clock.period, dtype=np.float64)
    return Column(CLOCK, "s")


def _counted(values: Array, c: Column, where: str, notes: list[str], problems: list[str]) -> Array:
    """Counts in two's complement as numbers with a sign, and what wraps followed over its ends."""
    if c.bits is None and c.wraps is None:
        _tell_wrap(values, c, notes)
        return values
    try:
        counts = values if c.bits is None else signed(values, c.bits)
        followed = counts if c.wraps is None else unwrapped(counts, c.wraps)
    except ValueError as error:
        problems.append(f"{where}: column {c.column!r}: {error}")
        return values
    told = [] if c.bits is None else [f"read as {c.bits} bits in two's complement"]
    if c.wraps is not None:
        times = int(np.sum(np.abs(np.diff(counts)) > 0.5 * c.wraps))
        told.append(f"followed {times} times over the ends of its range of {c.wraps:.7g}")
    n = int(np.sum(followed != values))
    notes.append(f"{c.column!r}: {' and '.join(told)}, {n} of {len(values)} rows changed")
    return followed


def _tell_wrap(values: Array, c: Column, notes: list[str]) -> None:
    """Say of a column that wraps and is taken as it is that it does."""
    wrap = wrap_of(values) if np.isfinite(values).all() else None
    if wrap is not None:
        notes.append(f"{c.column!r}: {wrap}; taken as it is: write {wrap.entry} if it is one")


def _signal(values: Array, c: Column) -> Array:
    named = unit(c.unit)
    scaled = c.sign * c.scale * named.factor * values
    return np.asarray((scaled + named.offset if named.offset else scaled) - c.offset)


def _missing(table: Table, sources: Mapping[str, Column], where: str) -> list[str]:
    return [
        f"{where}: column for {name}: got {c.column!r}, expected one of {[*table.columns]}"
        for name, c in sources.items()
        if c.column not in table.columns
    ]


def _units(table: Table, sources: Mapping[str, Column], where: str) -> list[str]:
    problems = []
    for name, c in sources.items():
        try:
            given = unit(c.unit)
        except ValueError as error:
            problems.append(f"{where}: column {c.column!r}: {error}")
            continue
        if name == "time" and given.exponents != {"s": 1}:
            problems.append(f"{where}: column {c.column!r}: got the unit {c.unit!r}, expected a time")
        elif c.column in table.dates and (given.exponents != {"s": 1} or given.factor != 1.0):
            problems.append(
                f"{where}: column {c.column!r}: got the unit {c.unit!r}, expected s: its dates are "
                "read as seconds since the first"
            )
        if c.sign not in (-1, 1):
            problems.append(f"{where}: column {c.column!r}: sign, got {c.sign!r}, expected 1 or -1")
    return problems


def _lengths(table: Table, sources: Mapping[str, Column], where: str) -> list[str]:
    names = [c.column for c in sources.values() if c.column in table.columns]
    lengths = {name: len(table.columns[name]) for name in names}
    if len(set(lengths.values())) > 1:
        return [f"{where}: columns have different lengths: {lengths}"]
    return []


def _other_clocks(table: Table, sources: Mapping[str, Column], where: str) -> list[str]:
    """Columns that another clock of the file has stamped than the times: their rows are of other instants."""
    clocks = {name: table.clocks[c.column] for name, c in sources.items() if c.column in table.clocks}
    if not clocks:
        return []
    own = clocks.get("time", next(iter(clocks.values())))
    apart: dict[str, list[str]] = {}
    for name, clock in clocks.items():
        if not same_clock(table, own, clock):
            apart.setdefault(clock, []).append(name)
    return [
        f"{where}: columns of {', '.join(names)}: got the clock {clock!r}, another one than {own!r}, "
        f"expected merge: {{file: {table.path.name}, time: {{column: {clock!r}}}, "
        f"signals: [{', '.join(names)}]}}"
        for clock, names in apart.items()
    ]


def same_clock(table: Table, one: str, other: str) -> bool:
    """Whether two columns of times of a file stamp the same instants, within a small part of a step."""
    if one == other:
        return True
    a = table.columns[one]
    b = table.columns[other]
    if len(a) != len(b) or len(a) < 2:
        return False
    return bool(np.abs(a - b).max() <= SAME_INSTANT * abs(float(np.median(np.diff(a)))))


def _cells(table: Table, sources: Mapping[str, Column], where: str) -> list[str]:
    names = [c.column for c in sources.values() if c.column in table.columns]
    problems = list(table.faults.get("", []))
    for column in dict.fromkeys(names):
        if column in table.faults or "" in table.faults:
            problems += table.faults.get(column, [])
            continue
        values = table.columns[column]
        bad = np.flatnonzero(~np.isfinite(values))
        faults = [
            f"{where}: row {i + table.first_row}, column {column!r}: got {values[i]}, expected a number"
            for i in bad
        ]
        problems += shortened(faults, f"in column {column!r}")
    return problems


def _rate_faults(t: Array, signals: Mapping[str, Array], rules: Rules, where: str) -> list[str]:
    problems = []
    for name, rate in rules.rates.items():
        if name not in signals or rate not in signals or len(t) < rules.fewest:
            continue
        displacement = signals[name] - signals[name][0]
        integral = np.concatenate(
            [[0.0], np.cumsum(0.5 * (signals[rate][1:] + signals[rate][:-1]) * np.diff(t))]
        )
        scale = _slope(integral, displacement)
        if not LEAST_RATE < scale < LARGEST_RATE:
            problems.append(
                f"{where}: {rate} is not the rate of {name}: its integral is {scale:.3g} of its change, "
                "expected about 1 (wrong unit, scale or sign?)"
            )
    return problems


def _slope(values: Array, against: Array) -> float:
    a = values - values.mean()
    b = against - against.mean()
    power = float(b @ b)
    return float(a @ b) / power if power > 0.0 else 1.0

"""Recordings: columns of a file as signals in SI units on one even time grid, or all faults at once."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from master.diagnosis.numerics.arrays import Array
from master.errors import DataError
from master.fmi.unit_names import unit
from master.recording.tables import Table, read_table, shortened

FEWEST_SAMPLES = 200  # of a recording: below, no part of it says anything
JITTER = 0.05  # of a step, by which it may differ from the usual one
GAP = 1.5  # of the usual step: a longer one is a gap
CLOCK_TOLERANCE = 1e-3  # of the sampling period, by which the mean step may differ
LEAST_RATE = 0.5  # slope of a rate's integral over its signal: no two units differ by so little
LARGEST_RATE = 2.0
CLOCK = "(time of the row)"  # name of a column that is made where there is none


@dataclass(frozen=True)
class Column:
    """How a column becomes a signal: sign * scale * column, from `unit` to SI, minus `offset` [SI]."""

    column: str
    unit: str
    scale: float = 1.0
    sign: int = 1
    offset: float = 0.0


@dataclass(frozen=True)
class Rules:
    """
    What a recording must keep.

    `period` [s] is what its clock should say (None: not known), `start` the time [s] of its first row.
    `rates` maps a signal to the one that is its time derivative.
    """

    fewest: int = FEWEST_SAMPLES
    period: float | None = None
    start: float | None = 0.0
    jitter: float = JITTER
    rates: Mapping[str, str] = field(default_factory=dict)


@dataclass(frozen=True)
class Recording:
    """Signals in SI units, shape (n,) each, at times t [s] with the period [s]."""

    name: str
    t: Array
    signals: Mapping[str, Array]
    period: float

    def __len__(self) -> int:
        return len(self.t)

    def __getitem__(self, signal: str) -> Array:
        return self.signals[signal]


def read(
    path: str | Path,
    time: Column | None,
    columns: Mapping[str, Column],
    *,
    rules: Rules | None = None,
    array: str | None = None,
    rows: tuple[int, int] | None = None,
) -> Recording:
    """
    Read a recording; nothing is resampled, filled or cut.

    Args:
        path: File of a format in `master.recording.tables.FORMATS`.
        time: Column of the time; None: rows are `rules.period` apart.
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
        *_cells(table, sources, where),
    ]
    if problems:
        raise DataError("\n".join(problems))
    signals: dict[str, Array] = {n: _signal(table.columns[c.column], c) for n, c in sources.items()}
    t = signals.pop("time")
    problems = [*_time_faults(t, rules, table, where), *_rate_faults(t, signals, rules, where)]
    if problems:
        raise DataError("\n".join(problems))
    return Recording(array or table.path.stem, t, signals, float((t[-1] - t[0]) / (len(t) - 1)))


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
    if rules.period is None:
        raise DataError(f"{table.path}: no time, expected a column or a period")
    longest = max((len(values) for values in table.columns.values()), default=0)
    table.columns[CLOCK] = np.asarray(np.arange(longest) * rules.period, dtype=np.float64)
    return Column(CLOCK, "s")


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


def _cells(table: Table, sources: Mapping[str, Column], where: str) -> list[str]:
    names = [c.column for c in sources.values() if c.column in table.columns]
    lengths = {name: len(table.columns[name]) for name in names}
    problems = list(table.faults.get("", []))
    if len(set(lengths.values())) > 1:
        problems.append(f"{where}: columns have different lengths: {lengths}")
    for column in lengths:
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


def _time_faults(t: Array, rules: Rules, table: Table, where: str) -> list[str]:
    if len(t) < max(rules.fewest, 3):
        return [f"{where}: too few samples, got {len(t)}, expected at least {rules.fewest}"]
    steps = np.diff(t)
    back = np.flatnonzero(steps <= 0.0)
    rows = back + 1 + table.first_row
    problems = [
        f"{where}: row {row}: time goes from {t[i]:.9g} to {t[i + 1]:.9g} s, expected it to grow"
        for i, row in zip(back, rows, strict=True)
    ]
    return [
        *shortened(problems, "steps back"),
        *_step_faults(t, steps, rules, table, where),
        *_clock_faults(t, steps, rules, where),
    ]


def _step_faults(t: Array, steps: Array, rules: Rules, table: Table, where: str) -> list[str]:
    usual = float(np.median(np.abs(steps)))
    is_back = steps <= 0.0
    is_known = is_back | np.concatenate([[False], is_back[:-1]])  # a step back, and what makes up for it
    is_gap = (steps > GAP * usual) & ~is_known
    is_jitter = (np.abs(steps - usual) > rules.jitter * usual) & ~is_gap & ~is_known
    problems: list[str] = []
    for chosen, what in ((is_gap, "gap"), (is_jitter, "jitter")):
        faults = [
            f"{where}: row {i + 1 + table.first_row}: {what}, got a step of {steps[i]:.6g} s after "
            f"t={t[i]:.9g} s, expected {usual:.6g} s"
            for i in np.flatnonzero(chosen)
        ]
        problems += shortened(faults, f"rows with {what}")
    return problems


def _clock_faults(t: Array, steps: Array, rules: Rules, where: str) -> list[str]:
    problems = []
    period = float(np.median(steps))
    if rules.start is not None and abs(t[0] - rules.start) > 0.5 * period:
        problems.append(
            f"{where}: clock offset, got a first time of {t[0]:.9g} s, expected {rules.start:.9g} s "
            "(give the time column an offset)"
        )
    mean = float((t[-1] - t[0]) / len(steps))
    if rules.period is not None and abs(mean / rules.period - 1.0) > CLOCK_TOLERANCE:
        problems.append(f"{where}: sampling period, got {mean:.9g} s, expected {rules.period:.9g} s")
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

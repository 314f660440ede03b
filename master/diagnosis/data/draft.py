"""A case drafted from a recording: what its columns show, and guesses that are marked as guesses."""

from __future__ import annotations

import json
import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from master.diagnosis.numerics.arrays import Array
from master.diagnosis.numerics.noise_floor import noise_floor, step_of
from master.errors import DataError
from master.fmi.unit_names import unit
from master.recording.tables import Table, read_table

from .clock import GAP, JITTER
from .recordings import FEWEST_SAMPLES

_IN_NAME = re.compile(r"^(.*?)\s*[\[(]([^\])]+)[\])]$")
_POSITION = re.compile(r"pos|disp|dist|stroke|way|^[xqsy]\b|^[xqsy]_", re.IGNORECASE)
_FORCE = re.compile(r"forc|load|^f\b|^f_", re.IGNORECASE)
_SHARE_OF_RATE = 0.1  # of the sampling rate: low-pass before a position is differentiated
_PATTERN = (
    "[fit, select, fit, sealed, fit, select, fit, select, fit, sealed, fit, select, fit, select, fit, sealed]"
)
_GUARD_OF_BLOCK = 0.2
_N_BLOCKS = 16


@dataclass(frozen=True)
class DraftColumn:
    """
    What a column of numbers shows.

    `unit` is "" where nothing tells it, `source` what tells it; `step` is that of its numbers, 0 without one;
    `floor` its noise floor and `evidence` what that is read from. All in the unit of the column.
    """

    name: str
    unit: str
    source: str
    low: float
    high: float
    step: float
    floor: float
    evidence: str


@dataclass(frozen=True)
class DraftClock:
    """Column of the time, its unit, begin and period in it, and rows after a gap or with jitter."""

    column: str
    unit: str
    begin: float
    period: float
    n_gaps: int
    n_jitter: int


@dataclass(frozen=True)
class Facts:
    """What a recording shows: its clock, its columns, and what a reader said of it."""

    table: Table
    clock: DraftClock | None
    columns: tuple[DraftColumn, ...]
    left_out: tuple[str, ...]

    @property
    def n_rows(self) -> int:
        """Rows of the columns that are kept."""
        return max((len(self.table.columns[c.name]) for c in self.columns), default=0)


def facts_of(path: Path) -> Facts:
    """
    Look at the columns of a recording.

    Raises:
        DataError: If the file cannot be read, or has fewer than two columns of numbers.
    """
    table = read_table(path)
    if table.faults.get(""):
        raise DataError("\n".join(table.faults[""]))
    lengths = [len(values) for values in table.columns.values()]
    n = max(set(lengths), key=lengths.count)
    whole = [
        name
        for name, values in table.columns.items()
        if name not in table.faults and len(values) == n and np.isfinite(values).all()
    ]
    left_out = tuple(name for name in table.columns if name not in whole)
    if len(whole) < 2 or n < FEWEST_SAMPLES:
        got = f"got {len(whole)} columns of {n} numbers (not: {', '.join(left_out) or 'none'})"
        raise DataError(f"{path}: {got}, expected two or more of {FEWEST_SAMPLES} rows or more")
    clock = _clock(table, whole)
    moving = [n for n in whole if (clock is None or n != clock.column) and np.ptp(table.columns[n])]
    period = 1.0 if clock is None else clock.period * unit(clock.unit).factor
    columns = tuple(_column(table, name, moving, period) for name in moving)
    return Facts(table, clock, columns, left_out)


def case_text(name: str, files: Sequence[str], facts: Facts) -> str:
    """Write the case as YAML: `files` as seen from its folder; every guess has a comment."""
    position = _first(facts.columns, "m", _POSITION, but=())
    force = _first(facts.columns, "N", _FORCE, but=(position,))
    period = 0.001 if facts.clock is None else facts.clock.period * unit(facts.clock.unit).factor
    guard = min(0.2, _GUARD_OF_BLOCK * facts.n_rows * period / _N_BLOCKS)
    lines = [
        f"name: {json.dumps(name)}",
        "# Drafted from the recording. Every line with 'guess' is one: look at it before you run.",
        *(f"# {line}" for line in report(facts)),
        "fmus:",
        "  axis: {source: servo_axis_inverse, parameters: {mass: 100, damping: 200}}  # guess: the model",
        "recordings:",
        *(f"  {_key(file, i)}: {json.dumps(file)}" for i, file in enumerate(files)),
        _time_line(facts.clock),
        "signals:",
        _signal_line("q", position, "m", f", lowpass: {_SHARE_OF_RATE / period:.4g}"),
        "  der_q: {rate_of: q}",
        "  der_der_q: {rate_of: der_q}",
        _signal_line("force", force, "N", ""),
        "inputs: {axis.q: q, axis.der_q: der_q, axis.der_der_q: der_der_q}  # guess: what drives",
        "compared: {axis.force: force}  # guess: what the model should give",
        "refit:  # guess: bounds",
        "  axis.mass: {low: 0.01, high: 10000}",
        "  axis.damping: {low: 0, high: 100000}",
        "split:",
        f"  blocks: {_PATTERN}",
        f"  guard: {guard:.4g}",
    ]
    return "\n".join(lines) + "\n"


def report(facts: Facts) -> list[str]:
    """What a recording shows, a line each for the file, its clock and every column."""
    clock = facts.clock
    lines = [f"{facts.table.path.name}: {facts.n_rows} rows" + "".join(f", {n}" for n in facts.table.notes)]
    if clock is None:
        lines.append("no column grows as a clock does: the period is not known")
    else:
        lines.append(
            f"clock {clock.column!r}: period {clock.period:.6g} {clock.unit}, {clock.n_gaps} gaps, "
            f"{clock.n_jitter} rows with jitter"
        )
    for c in facts.columns:
        step = f", steps of {c.step:.4g}" if c.step else ""
        told = f"{c.unit} ({c.source})" if c.unit else "unit not told"
        lines.append(
            f"{c.name!r}: {c.low:.5g} to {c.high:.5g}, {told}, noise {c.floor:.3g} by {c.evidence}{step}"
        )
    if facts.left_out:
        lines.append(
            f"left out, not all numbers or of another length: {', '.join(map(repr, facts.left_out))}"
        )
    return [" ".join(line.split()) for line in lines]


def _clock(table: Table, names: Sequence[str]) -> DraftClock | None:
    """The column that grows most evenly, if one does."""
    found: list[tuple[float, DraftClock]] = []
    for name in names:
        values = table.columns[name]
        steps = np.diff(values)
        if not np.all(steps > 0.0):
            continue
        usual = float(np.median(steps))
        gaps = steps > GAP * usual
        jitter = (np.abs(steps - usual) > JITTER * usual) & ~gaps
        told, _ = _unit(table, name)
        is_time = bool(told) and unit(told).exponents == {"s": 1}
        clock = DraftClock(
            name, told if is_time else "s", float(values[0]), usual, int(gaps.sum()), int(jitter.sum())
        )
        found.append((float(jitter.mean() + gaps.mean()) - is_time, clock))
    return min(found, key=lambda pair: pair[0])[1] if found else None


def _column(table: Table, name: str, moving: Sequence[str], period: float) -> DraftColumn:
    values: Array = table.columns[name]
    others = [table.columns[other] for other in moving if other != name]
    driving = np.column_stack(others) if others else np.empty((len(values), 0))
    floor = noise_floor([values], [driving], period)
    told, source = _unit(table, name)
    return DraftColumn(
        name=name,
        unit=told,
        source=source,
        low=float(values.min()),
        high=float(values.max()),
        step=step_of(values),
        floor=floor.value,
        evidence=floor.evidence.value,
    )


def _unit(table: Table, name: str) -> tuple[str, str]:
    """Unit of a column and what tells it; "" where nothing does, or none that is known."""
    if name in table.dates:
        return "s", "dates"
    in_name = _IN_NAME.match(name)
    for told, source in ((table.units.get(name, ""), "file"), (in_name[2] if in_name else "", "its name")):
        plain = told.strip().strip("[](){}<>").strip()
        if plain:
            try:
                unit(plain)
            except ValueError:
                continue
            return plain, source
    return "", ""


def _first(
    columns: Sequence[DraftColumn], si: str, pattern: re.Pattern[str], but: Sequence[DraftColumn | None]
) -> DraftColumn | None:
    """The first column of a unit, else of a name that fits, else any other."""
    free = [c for c in columns if c not in but]
    exponents = unit(si).exponents
    by_unit = [c for c in free if c.unit and unit(c.unit).exponents == exponents]
    by_name = [c for c in free if pattern.search(c.name)]
    return next(iter([*by_unit, *by_name, *free]), None)


def _signal_line(key: str, column: DraftColumn | None, si: str, more: str) -> str:
    if column is None:
        return f"  {key}: {{column: ?, unit: {si}{more}}}  # no column is left for it"
    fits = bool(column.unit) and unit(column.unit).exponents == unit(si).exponents
    told = (
        f"guess: the column; the unit is told by {column.source}"
        if fits
        else "guess: the column and its unit"
    )
    shown = column.unit if fits else si
    return f"  {key}: {{column: {json.dumps(column.name)}, unit: {json.dumps(shown)}{more}}}  # {told}"


def _time_line(clock: DraftClock | None) -> str:
    if clock is None:
        return "time: {period: 0.001}  # guess: no clock was found"
    offset = clock.begin * unit(clock.unit).factor
    begin = f", offset: {offset!r}" if offset else ""
    entry = f"{{column: {json.dumps(clock.column)}, unit: {clock.unit}{begin}}}"
    return f"time: {entry}  # guess: the unit, if not told"


def _key(file: str, i: int) -> str:
    plain = re.sub(r"\W+", "_", Path(file).stem).strip("_")
    return plain if plain and i == 0 else f"{plain or 'run'}_{i + 1}"

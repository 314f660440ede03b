"""A case drafted from a recording: what its columns show, and guesses that are marked as guesses."""

from __future__ import annotations

import json
import re
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from fmu_sources.composed import registry
from fmu_sources.framework.variables import Role
from master.diagnosis.numerics.arrays import Array
from master.diagnosis.numerics.noise_floor import noise_floor, step_of
from master.errors import DataError
from master.fmi.unit_names import unit
from master.recording.tables import Table, read_table

from .clock import GAP, JITTER, Clock, coarsest_print, is_uneven, straightened
from .counts import Wrap, wrap_of
from .recordings import FEWEST_SAMPLES, same_clock
from .rig_proposals import Proposal, Told, proposed
from .rigs_by_data import by_data

_IN_NAME = re.compile(r"^(.*?)\s*[\[(]([^\])]+)[\])]$")
_AT_END = re.compile(  # of one letter, `p_A` is as likely a place as a unit
    r"^(.+)_([mu]s|min|[mucd]m|kN|k?Nm|[hkM]?Pa|m?bar|psi|degC|degF|deg|rad|rpm|[mk]V|mA|kW|k?Hz)$"
)
_SPOKEN = {"Nm": "N m", "kNm": "kN m", "degrees": "deg", "sec": "s", "seconds": "s"}  # never nanometres
_TIME = re.compile(r"time|clock|stamp|zeit|^t\b|^t_|^sec", re.IGNORECASE)
_STAMP = ".stamp"  # of a message of ROS, by its sender; its own time is when it was recorded
_WINDOW = 200  # rows of a replay of a model that drifts
_FACTOR = 1000.0  # of a parameter, over and below where a rig starts
_WIDE = 1e5  # bound of one that starts at 0
_FASTEST = 100.0  # ranges of a column in the time of the recording: a bound of its rate
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
    `floor` its noise floor and `evidence` what that is read from. All in the unit of the column. `logger` is
    the place of its clock among those of the file. `wrap`: it goes over the ends of its range; low and high
    are those of what it is when it is followed there.
    """

    name: str
    unit: str
    source: str
    low: float
    high: float
    step: float
    floor: float
    evidence: str
    logger: int = 0
    wrap: Wrap | None = None


@dataclass(frozen=True)
class DraftClock:
    """Column of the time, its unit, begin and period in it, and rows after a gap or with jitter."""

    column: str
    unit: str
    begin: float
    period: float
    n_gaps: int
    n_jitter: int
    is_short: bool = False


@dataclass(frozen=True)
class Facts:
    """
    What a recording shows: its clocks, its columns, and what a reader said of it.

    A file of several loggers has a clock for each, the one with most rows first; None where none was found.
    `constants` are columns that never change: their value and unit, "" where nothing tells it.
    """

    table: Table
    clocks: tuple[DraftClock | None, ...]
    columns: tuple[DraftColumn, ...]
    left_out: tuple[str, ...]
    constants: Mapping[str, tuple[float, str]] = field(default_factory=dict)

    @property
    def clock(self) -> DraftClock | None:
        """The clock of the first logger."""
        return self.clocks[0]

    @property
    def n_rows(self) -> int:
        """Rows of the columns that are kept, of the first logger."""
        return self.rows_of(0)

    def rows_of(self, logger: int) -> int:
        """Rows of the columns of one logger."""
        return max((len(self.table.columns[c.name]) for c in self.columns if c.logger == logger), default=0)


def facts_of(path: Path) -> Facts:
    """
    Look at the columns of a recording.

    Raises:
        DataError: If the file cannot be read, or has fewer than two columns of numbers.
    """
    table = read_table(path)
    if table.faults.get(""):
        raise DataError("\n".join(table.faults[""]))
    loggers = _loggers(table)
    whole = [name for names in loggers for name in names]
    left_out = tuple(name for name in table.columns if name not in whole)
    if len(whole) < 2 or len(table.columns[whole[0]]) < FEWEST_SAMPLES:
        n = max((len(values) for values in table.columns.values()), default=0)
        got = f"got {len(whole)} columns of {n} numbers (not: {', '.join(left_out) or 'none'})"
        raise DataError(f"{path}: {got}, expected two or more of {FEWEST_SAMPLES} rows or more")
    clocks = []
    columns: list[DraftColumn] = []
    constants: dict[str, tuple[float, str]] = {}
    for logger, names in enumerate(loggers):
        clock = _clock(table, names)
        others = [n for n in names if clock is None or not _is_clock(table, clock.column, n)]
        moving = [n for n in others if np.ptp(table.columns[n])]
        constants |= {n: (float(table.columns[n][0]), _unit(table, n)[0]) for n in others if n not in moving}
        period = 1.0 if clock is None else clock.period * unit(clock.unit).factor
        clocks.append(clock)
        columns += [_column(table, name, moving, period, logger) for name in moving]
    return Facts(table, tuple(clocks), tuple(columns), left_out, constants)


def _is_clock(table: Table, clock: str, name: str) -> bool:
    """Whether a column is the clock, or that of another channel which is the same."""
    return name == clock or (name in table.clocks.values() and same_clock(table, clock, name))


def _loggers(table: Table) -> list[list[str]]:
    """Columns of numbers by the clock that stamps them, those with most rows first."""
    numbers = [
        name
        for name, values in table.columns.items()
        if name not in table.faults and np.isfinite(values).all()
    ]
    clocks: list[str] = []
    for clock in dict.fromkeys(table.clocks.get(name, "") for name in numbers):
        if clock and not any(same_clock(table, known, clock) for known in clocks):
            clocks.append(clock)
    if len(clocks) < 2:
        lengths = [len(values) for values in table.columns.values()]
        n = max(set(lengths), key=lengths.count, default=0)
        return [[name for name in numbers if len(table.columns[name]) == n]]
    found = [
        [name for name in numbers if name in table.clocks and same_clock(table, clock, table.clocks[name])]
        for clock in clocks
        if len(table.columns[clock]) >= FEWEST_SAMPLES
    ]
    return sorted(found, key=lambda names: -len(table.columns[names[0]])) or [[]]


def case_text(name: str, files: Sequence[str], facts: Facts) -> str:
    """Write the case as YAML: `files` as seen from its folder; every guess has a comment."""
    logger = {c.name: c.logger for c in facts.columns}
    rigs = _proposed(facts)
    found = rigs[0] if rigs else None
    used = [] if found is None else sorted({logger[column] for column in found.columns.values()})
    first = used[0] if used else 0
    clock = facts.clocks[first]
    n_rows = facts.rows_of(first)
    merge = _merge_text(found, facts, used[1], clock) if found is not None and len(used) > 1 else None
    period = 0.001 if clock is None else clock.period * unit(clock.unit).factor
    guard = min(0.2, _GUARD_OF_BLOCK * n_rows * period / _N_BLOCKS)
    lines = [
        f"name: {json.dumps(name)}",
        "# Drafted from the recording. Every line with 'guess' is one: look at it before you run.",
        *(f"# {line}" for line in report(facts)),
        "recordings:",
        *(_recording_line(_key(file, i), file, merge) for i, file in enumerate(files)),
        *_time_lines(clock),
        *(_without_model(facts) if found is None else _model_lines(rigs, facts, period, n_rows)),
        "split:",
        f"  blocks: {_PATTERN}",
        f"  guard: {guard:.4g}",
    ]
    return "\n".join(lines) + "\n"


def _proposed(facts: Facts) -> list[Proposal]:
    """Rigs for the columns of at most two loggers: a recording of a case has one more than its own."""
    found = proposed([Told(c.name, c.unit) for c in facts.columns])
    if not found:
        return []
    logger = {c.name: c.logger for c in facts.columns}
    used = Counter(logger[column] for column in found[0].columns.values())
    if len(used) > 2:
        kept = {place for place, _ in used.most_common(2)}
        found = proposed([Told(c.name, c.unit) for c in facts.columns if c.logger in kept])
    return by_data(found, facts)


def _merge_text(found: Proposal, facts: Facts, logger: int, first: DraftClock | None) -> str:
    """The clock of a second logger in the same file, and the signals that it has."""
    own = {c.name for c in facts.columns if c.logger == logger}
    signals = ", ".join(variable for variable, column in found.columns.items() if column in own)
    clock = facts.clocks[logger]
    time = "{period: 0.001}" if clock is None else _time_entry(clock, first)
    return f"time: {time}, signals: [{signals}]"


def _recording_line(key: str, file: str, merge: str | None) -> str:
    name = json.dumps(file)
    if merge is None:
        return f"  {key}: {name}"
    return f"  {key}: {{file: {name}, merge: {{file: {name}, {merge}}}}}  # guess: two clocks, no delay"


def _model_lines(rigs: Sequence[Proposal], facts: Facts, period: float, n_rows: int) -> list[str]:
    """The first rig, its signals, what drives it, what it gives, and what may be a wrong number."""
    told = {c.name: c for c in facts.columns}
    found = rigs[0]
    rig = found.rig
    also = " or ".join(dict.fromkeys(own.rig.source for own in rigs[1:]))
    guessed = f"guess: the model; it may be {also}" if also else "guess: the model"
    model = registry.load(rig.source)
    fmu = "axis" if "axis" in rig.source else "rig"
    units = {v.name: v.unit for v in model.all_variables}
    made = ", ".join(f"{fmu}.{v}: {v}" for v in (*rig.drives, *rig.rates))
    given = ", ".join(f"{fmu}.{v}: {v}" for v in found.compared)
    lines = [f"fmus: {{{fmu}: {{source: {rig.source}}}}}  # {guessed}", "signals:"]
    for variable, column in found.columns.items():
        is_rated = variable in rig.rates.values()
        low_pass = f", lowpass: {_SHARE_OF_RATE / period:.4g}" if is_rated else ""
        lines.append(_signal_line(variable, told[column], units[variable], low_pass))
    lines += [f"  {rate}: {{rate_of: {of}}}" for rate, of in rig.rates.items()]
    lines += [
        f"inputs: {{{made}}}  # guess: what drives",
        f"compared: {{{given}}}  # guess: what the model should give",
    ]
    if rig.set:
        lines.append("set:")
        lines += [_set_line(f"{fmu}.{v}", value, units[v], facts) for v, value in rig.set.items()]
    lines.append("refit:  # guess: bounds")
    starts = {v.name: v for v in model.group(Role.PARAMETER)}
    for parameter in rig.refit:
        own = starts[parameter]
        is_signed = own.minimum is None and own.above is None
        low, high = _bounds(float(own.start), is_signed=is_signed)
        if own.minimum is not None:
            low = own.minimum
        lines.append(f"  {fmu}.{parameter}: {{low: {low:g}, high: {high:g}}}")
    if rig.states:
        lines.append("starts:  # guess: what was not measured at the begin, from the range of the columns")
        for state in rig.states:
            low, high = _range(state, found, told, period * n_rows, units)
            lines.append(f"  {fmu}.{state}: [{low:.6g}, {high:.6g}]")
    if rig.drifts:
        lines.append(f"replay: {{windows: {{{fmu}: {_WINDOW * period:g}}}}}  # guess: the model drifts")
    return lines


def _set_line(key: str, value: float, si: str, facts: Facts) -> str:
    """A value that is seldom recorded: that of the one constant column of its dimensions, if there is one."""
    fitting = {
        name: unit(told).factor * constant + unit(told).offset
        for name, (constant, told) in facts.constants.items()
        if told and unit(told).exponents == unit(si).exponents
    }
    if len(fitting) != 1:
        return f"  {key}: {value:g}  # guess: not recorded"
    ((name, constant),) = fitting.items()
    return f"  {key}: {constant!r}  # guess: the column {json.dumps(name)}, which never changes"


def _without_model(facts: Facts) -> list[str]:
    names = ", ".join(c.name for c in facts.columns)
    return [f"# No model fits the columns {names}: write fmus, signals, inputs, compared here"]


def _bounds(start: float, *, is_signed: bool) -> tuple[float, float]:
    if start == 0.0:
        return (-_WIDE if is_signed else 0.0), _WIDE
    low = -_FACTOR * abs(start) if is_signed else start / _FACTOR
    return low, _FACTOR * abs(start)


def _range(
    state: str, found: Proposal, told: Mapping[str, DraftColumn], duration: float, units: Mapping[str, str]
) -> tuple[float, float]:
    """Where a state may begin: the range of its column, or of what its rate may be [SI]."""
    column = told[found.columns.get(state) or found.columns[state.removeprefix("der_")]]
    is_told = bool(column.unit) and unit(column.unit).exponents == unit(units[state]).exponents
    scale = unit(column.unit) if is_told else unit("1")
    low, high = (scale.factor * v + scale.offset for v in (column.low, column.high))
    if state in found.columns:
        return low, high
    scale = unit(column.unit) if column.unit else unit("1")
    most = _FASTEST * scale.factor * (column.high - column.low) / max(duration, 1e-9)
    return -most, most


def report(facts: Facts) -> list[str]:
    """What a recording shows, a line each for the file, its clock and every column."""
    lines = [f"{facts.table.path.name}: {facts.n_rows} rows" + "".join(f", {n}" for n in facts.table.notes)]
    for logger, clock in enumerate(facts.clocks):
        if clock is None:
            lines.append("no column grows as a clock does: the period is not known")
            continue
        rows = f", {facts.rows_of(logger)} rows" if len(facts.clocks) > 1 else ""
        lines.append(
            f"clock {clock.column!r}: period {clock.period:.6g} {clock.unit}, {clock.n_gaps} gaps, "
            f"{clock.n_jitter} rows with jitter{', printed short' if clock.is_short else ''}{rows}"
        )
    for c in facts.columns:
        step = f", steps of {c.step:.4g}" if c.step else ""
        told = f"{c.unit} ({c.source})" if c.unit else "unit not told"
        wrap = f", {c.wrap}; followed" if c.wrap else ""
        noise = f"noise {c.floor:.3g} by {c.evidence}{step}"
        lines.append(f"{c.name!r}: {c.low:.5g} to {c.high:.5g}, {told}, {noise}{wrap}")
    if facts.constants:
        shown = (f"{name!r} {value:.5g} {told}".rstrip() for name, (value, told) in facts.constants.items())
        lines.append(f"never change: {', '.join(shown)}")
    if facts.left_out:
        lines.append(
            f"left out, not all numbers or of another length: {', '.join(map(repr, facts.left_out))}"
        )
    return [" ".join(line.split()) for line in lines]


def _clock(table: Table, names: Sequence[str]) -> DraftClock | None:
    """The column that grows most evenly, if one does; of equals, the stamp that a sensor has given."""
    found: list[tuple[float, bool, DraftClock]] = []
    for name in names:
        values = table.columns[name]
        told, _ = _unit(table, name)
        is_time = bool(told) and unit(told).exponents == {"s": 1}
        short = _straightened(values) if is_time or _TIME.search(name) else None
        steps = np.diff(values if short is None else short.t)
        if not np.all(steps > 0.0):
            continue
        usual = float(np.median(steps))
        gaps = steps > GAP * usual
        jitter = (np.abs(steps - usual) > JITTER * usual) & ~gaps
        clock = DraftClock(
            column=name,
            unit=told if is_time else "s",
            begin=float(values[0]),
            period=usual,
            n_gaps=int(gaps.sum()),
            n_jitter=int(jitter.sum()),
            is_short=short is not None,
        )
        found.append((float(jitter.mean() + gaps.mean()) - is_time, not name.endswith(_STAMP), clock))
    return min(found, key=lambda entry: entry[:2])[2] if found else None


def _straightened(values: Array) -> Clock | None:
    """An uneven clock that is printed short, made even."""
    steps = np.diff(values)
    if np.any(steps < 0.0) or not np.any(np.abs(steps - np.median(steps)) > JITTER * np.median(steps)):
        return None
    printed = coarsest_print(values)
    return None if printed is None or not is_uneven(values, JITTER) else straightened(values, printed)


def _column(table: Table, name: str, moving: Sequence[str], period: float, logger: int) -> DraftColumn:
    values: Array = table.columns[name]
    wrap = wrap_of(values)
    if wrap is not None:
        values = wrap.followed(values)
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
        logger=logger,
        wrap=wrap,
    )


def _unit(table: Table, name: str) -> tuple[str, str]:
    """Unit of a column and what tells it; "" where nothing does, or none that is known."""
    if name in table.dates:
        return "s", "dates"
    in_name = _IN_NAME.match(name) or _AT_END.match(name)
    for told, source in ((table.units.get(name, ""), "file"), (in_name[2] if in_name else "", "its name")):
        plain = told.strip().strip("[](){}<>").strip()
        plain = _SPOKEN.get(plain, plain)
        if plain:
            try:
                unit(plain)
            except ValueError:
                continue
            return plain, source
    return "", ""


def _signal_line(key: str, column: DraftColumn, wanted: str, more: str) -> str:
    fits = bool(column.unit) and unit(column.unit).exponents == unit(wanted).exponents
    told = f"guess: the column; the unit is told by {column.source}"
    shown = column.unit
    if not fits:
        told = f"guess: the column and its unit{f', told as {column.unit}' if column.unit else ''}"
        shown = "1" if column.unit else wanted
    if column.wrap is not None:
        more += f", {column.wrap.entry}"
        told += "; and that it wraps there"
    return f"  {key}: {{column: {json.dumps(column.name)}, unit: {json.dumps(shown)}{more}}}  # {told}"


def _time_lines(clock: DraftClock | None) -> list[str]:
    if clock is None:
        return ["time: {period: 0.001}  # guess: no clock was found"]
    lines = [f"time: {_time_entry(clock, clock)}  # guess: the unit, if not told"]
    if clock.n_jitter:
        lines.append("resample: {method: linear}  # guess: rows with jitter are made even")
    return lines


def _time_entry(clock: DraftClock, first: DraftClock | None) -> str:
    """A clock from the begin of the first one, so that both say the same time."""
    offset = 0.0 if first is None else first.begin * unit(first.unit).factor
    begin = f", offset: {offset!r}" if offset else ""
    gaps = ", gaps: split" if clock.n_gaps else ""
    return f"{{column: {json.dumps(clock.column)}, unit: {clock.unit}{begin}{gaps}}}"


def _key(file: str, i: int) -> str:
    plain = re.sub(r"\W+", "_", Path(file).stem).strip("_")
    return plain if plain and i == 0 else f"{plain or 'run'}_{i + 1}"

"""
Two runs, signal by signal: how far they are apart, where first, and what cannot be compared.

Nothing is left out in silence: a signal or a row that only one run has, a value that is no number in one
of them, a unit that differs are differences, unless the caller asks for what both have.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from master.errors import ConfigError, DataError, Problem, nearest

from .run_data import Floats, RunData

_SAME_TIME = 1e-6  # of the shortest step between two rows: what rounding of times may be


@dataclass(frozen=True)
class Tolerance:
    """A bound on differences: `absolute` in the signal's unit, or as a share of its largest magnitude."""

    value: float
    is_relative: bool = False

    @classmethod
    def of(cls, text: str) -> Tolerance:
        """Read `1e-6` (absolute) or `0.1%` (relative); ValueError for anything else."""
        is_relative = text.strip().endswith("%")
        value = float(text.strip().removesuffix("%")) * (0.01 if is_relative else 1.0)
        if not (math.isfinite(value) and value >= 0.0):
            raise ValueError("not a finite number of at least 0")
        return cls(value, is_relative)

    def bound(self, reference: Floats) -> float:
        """Largest difference that is allowed, in the unit of a signal of shape (rows,)."""
        if not self.is_relative:
            return self.value
        finite = reference[np.isfinite(reference)]
        return self.value * float(np.max(np.abs(finite), initial=0.0))

    def __str__(self) -> str:
        return f"{100.0 * self.value:g} %" if self.is_relative else f"{self.value:g}"


@dataclass(frozen=True)
class Demands:
    """
    What a comparison asks for.

    `tolerance` holds for all signals that `by_signal` does not name; None asks for equal bits. `signals` are
    the only ones to be compared, all of them where none is named. `only_common` takes what both runs have.
    """

    tolerance: Tolerance | None = None
    by_signal: Mapping[str, Tolerance] = field(default_factory=dict)
    signals: tuple[str, ...] = ()
    only_common: bool = False


@dataclass(frozen=True)
class SignalDifference:
    """
    One signal in both runs; `other_name` is what the other run calls it.

    `max_abs` and `rms` are over the rows in which both are finite (None: there is no such row), in `unit`;
    `unequal` are rows whose bits differ, `beyond` those beyond the `bound` (None: equal bits), `no_numbers`
    of them those where not both are the same NaN or infinity. Times in s.
    """

    name: str
    other_name: str
    unit: str
    other_unit: str
    rows: int
    max_abs: float | None
    max_at: float | None
    rms: float | None
    unequal: int
    beyond: int
    no_numbers: int
    first_beyond: float | None
    bound: float | None

    @property
    def units_differ(self) -> bool:
        """Whether both runs name a unit, and not the same."""
        return bool(self.unit and self.other_unit) and self.unit != self.other_unit

    @property
    def is_within(self) -> bool:
        """Whether all rows are within the tolerance, in one unit."""
        return self.beyond == 0 and not self.units_differ


@dataclass(frozen=True)
class Comparison:
    """
    A run against the reference.

    `rows` are those at times that both have; `only_reference` and `only_other` count the others, and
    `missing` and `extra` name the signals that only the reference or only the other run has. `time_shift` [s]
    is how far the times of common rows are apart by rounding.
    """

    reference: RunData
    other: RunData
    demands: Demands
    rows: int
    only_reference: int
    only_other: int
    time_shift: float
    differences: tuple[SignalDifference, ...]
    missing: tuple[str, ...]
    extra: tuple[str, ...]

    @property
    def is_within(self) -> bool:
        """Whether the runs agree as far as was asked."""
        return not self.faults

    @property
    def faults(self) -> list[str]:
        """What is beyond what was asked, a line each."""
        faults = [] if self.demands.only_common else self.not_shared
        if self.time_shift and self.demands.tolerance is None and not self.demands.by_signal:
            faults = [*faults, f"times differ by up to {self.time_shift:.3g} s, expected equal bits"]
        return [*faults, *(_fault(d) for d in self.differences if not d.is_within)]

    @property
    def not_shared(self) -> list[str]:
        """What only one of the runs has, a line each."""
        lines = [f"{name}: only in {self.reference.label}" for name in self.missing]
        lines += [f"{name}: only in {self.other.label}" for name in self.extra]
        for n, run in ((self.only_reference, self.reference), (self.only_other, self.other)):
            if n:
                lines.append(f"time: {n} of {len(run.time)} rows only in {run.label}")
        return lines

    @property
    def renamed(self) -> list[str]:
        """Signals that have different names in the runs, a line each."""
        pairs = [(d.other_name, d.name) for d in self.differences if d.other_name != d.name]
        return [f"{other} of {self.other.label} is taken for {name}" for other, name in pairs]

    def as_dict(self) -> dict[str, Any]:
        """Return everything for JSON."""
        return {
            "reference": self.reference.label,
            "other": self.other.label,
            "within": self.is_within,
            "rows": self.rows,
            "rows_only_in_reference": self.only_reference,
            "rows_only_in_other": self.only_other,
            "time_shift": self.time_shift,
            "signals_only_in_reference": list(self.missing),
            "signals_only_in_other": list(self.extra),
            "faults": self.faults,
            "signals": [{**d.__dict__, "within": d.is_within} for d in self.differences],
        }


def compare_runs(reference: RunData, other: RunData, demands: Demands | None = None) -> Comparison:
    """
    Compare a run with a reference.

    Rows belong together whose times are equal but for rounding. A signal of a tool that names no instance
    (`h`) is taken for the one signal of the other run that ends with its name (`ball.h`).

    Raises:
        ConfigError: If a signal that the demands name is not in the reference.
        DataError: If the runs have no signal or no time in common.
    """
    demands = demands or Demands()
    _refuse_unknown(reference, demands)
    names = _names(reference, other)
    wanted = [name for name in reference.signals if name in demands.signals or not demands.signals]
    common = [name for name in wanted if name in names]
    if not common:
        raise DataError(f"{other.label}: no signal in common with {reference.label}, got {_listed(other)}")
    mine, theirs = common_rows(reference.time, other.time)
    if len(mine) == 0:
        span = f"{other.time[0]:.9g} to {other.time[-1]:.9g} s"
        expected = f"times of {reference.label}, {reference.time[0]:.9g} to {reference.time[-1]:.9g} s"
        raise DataError(f"{other.label}: no time in common, got {span}, expected {expected}")
    taken = set(names.values())
    time = reference.time[mine]
    return Comparison(
        reference=reference,
        other=other,
        demands=demands,
        rows=len(mine),
        only_reference=len(reference.time) - len(mine),
        only_other=len(other.time) - len(theirs),
        time_shift=float(np.max(np.abs(time - other.time[theirs]))),
        differences=tuple(
            _difference(reference, other, name, names[name], mine, theirs, demands) for name in common
        ),
        missing=tuple(name for name in wanted if name not in names),
        extra=() if demands.signals else tuple(name for name in other.signals if name not in taken),
    )


def _refuse_unknown(reference: RunData, demands: Demands) -> None:
    asked = [("--signal", name) for name in demands.signals]
    asked += [("--tolerance", name) for name in demands.by_signal]
    problems = [
        Problem(
            f"no such signal in {reference.label}",
            where=where,
            got=repr(name),
            expected=nearest(name, reference.signals),
        )
        for where, name in asked
        if name not in reference.signals
    ]
    if problems:
        raise ConfigError(problems)


def _listed(run: RunData) -> str:
    return ", ".join(list(run.signals)[:10]) + (", ..." if len(run.signals) > 10 else "") or "none"


def _names(reference: RunData, other: RunData) -> dict[str, str]:
    """Names of the reference to those of the other run: equal, or without the instance where one fits."""
    names = {name: name for name in reference.signals if name in other.signals}
    open_mine = [name for name in reference.signals if name not in names]
    open_theirs = [name for name in other.signals if name not in names]
    for mine, theirs in _by_ending(open_mine, open_theirs):
        names[mine] = theirs
    for theirs, mine in _by_ending(
        [n for n in open_theirs if n not in names.values()], [n for n in open_mine if n not in names]
    ):
        names[mine] = theirs
    return names


def _by_ending(long: Sequence[str], short: Iterable[str]) -> list[tuple[str, str]]:
    """Pairs of a name with an instance and its variable's name alone, where there is one for it."""
    pairs = []
    for name in short:
        fitting = [one for one in long if one.partition(".")[2] == name]
        if len(fitting) == 1:
            pairs.append((fitting[0], name))
    return pairs


def common_rows(mine: Floats, theirs: Floats) -> tuple[Any, Any]:
    """Return the rows of both that have the same time but for rounding; rows of one time in their order."""
    steps = np.concatenate([np.diff(mine), np.diff(theirs)])
    shortest = float(np.min(steps[steps > 0.0], initial=np.inf))
    slack = _SAME_TIME * shortest if math.isfinite(shortest) else 0.0
    if len(mine) == len(theirs) and np.all(np.abs(mine - theirs) <= slack):
        rows = np.arange(len(mine))
        return rows, rows
    pairs: list[tuple[int, int]] = []
    i = j = 0
    while i < len(mine) and j < len(theirs):
        if abs(mine[i] - theirs[j]) <= slack:
            pairs.append((i, j))
            i += 1
            j += 1
        elif mine[i] < theirs[j]:
            i += 1
        else:
            j += 1
    found = np.array(pairs, dtype=int).reshape(-1, 2)
    return found[:, 0], found[:, 1]


def _difference(
    reference: RunData, other: RunData, name: str, other_name: str, mine: Any, theirs: Any, demands: Demands
) -> SignalDifference:
    time = reference.time[mine]
    a, b = reference.signals[name][mine], other.signals[other_name][theirs]
    both_nan = np.isnan(a) & np.isnan(b)
    unequal = (a.view(np.int64) != b.view(np.int64)) & ~both_nan
    numbers = np.isfinite(a) & np.isfinite(b)
    with np.errstate(over="ignore", invalid="ignore"):
        apart = np.where(numbers, np.abs(a - b), 0.0)
    no_numbers = unequal & ~numbers
    tolerance = demands.by_signal.get(name, demands.tolerance)
    bound = None if tolerance is None else tolerance.bound(reference.signals[name])
    beyond = unequal if bound is None else no_numbers | (apart > bound)
    first = np.flatnonzero(beyond)
    worst = int(np.argmax(apart)) if numbers.any() else None
    scale = 0.0 if worst is None else float(apart[worst])
    rms = None
    if worst is not None:
        shares = apart[numbers] / scale if 0.0 < scale < np.inf else np.ones(1)  # squares do not overflow
        rms = scale * float(np.sqrt(np.mean(shares**2)))
    return SignalDifference(
        name=name,
        other_name=other_name,
        unit=reference.units.get(name, ""),
        other_unit=other.units.get(other_name, ""),
        rows=len(time),
        max_abs=_finite(scale) if worst is not None else None,
        max_at=None if worst is None else float(time[worst]),
        rms=None if rms is None else _finite(rms),
        unequal=int(np.count_nonzero(unequal)),
        beyond=int(np.count_nonzero(beyond)),
        no_numbers=int(np.count_nonzero(no_numbers)),
        first_beyond=float(time[first[0]]) if len(first) else None,
        bound=bound,
    )


def _finite(value: float) -> float:
    """Return what a double holds: a difference of two huge numbers may be larger than the largest."""
    return min(value, float(np.finfo(float).max))


def _fault(d: SignalDifference) -> str:
    if d.units_differ:
        return f"{d.name}: unit, got {d.other_unit}, expected {d.unit}"
    unit = f" {d.unit}" if d.unit not in ("", "1") else ""
    expected = "equal bits" if d.bound is None else f"at most {d.bound:.6g}{unit}"
    first = f"first at t = {d.first_beyond:.9g} s"
    where = f"in {d.beyond} of {d.rows} rows, {first}"
    if d.max_abs is None or (d.no_numbers == d.beyond and d.max_abs <= (d.bound or 0.0)):
        return f"{d.name}: not a number or infinite in one of the runs {where}"
    if d.max_abs == 0.0:
        return f"{d.name}: differs in the sign of zero {where}, expected {expected}"
    said = f", {d.no_numbers} of them without a number in one of the runs" if d.no_numbers else ""
    at = f"{d.max_abs:.6g}{unit} at t = {d.max_at:.9g} s"
    return f"{d.name}: differs by up to {at}, {where}{said}, expected {expected}"

"""
A part of software whose inputs were all recorded replays to rounding, or has a fault: which one?

Each fault that software is likely to have is played: on what drives the part, on what it gives, on a term
of its own that a switch turns off, on what is in a slot. A fault is found where the replay with it gives
the measurement but for rounding.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property, partial
from typing import Any, NamedTuple

import numpy as np
from scipy.optimize import least_squares

from master.diagnosis.numerics.arrays import TINY, Array, Mask
from master.diagnosis.numerics.noise_floor import step_of
from master.diagnosis.search.study import EXACT, Study
from master.fmi.description import Kind

TICKS = (1, -1, 2, -2, 3, -3)
HELD = (2, 3, 4, 5, 10)  # ticks that a stale value is held
NOTHING_LEFT = 1e-3  # of the residual before: what a fault leaves that explains it
FEW_ROWS = 0.05  # of all, that a logger may have dropped
MOST_ROWS = 0.9  # of those that do not replay
QUIET_ROWS = 10  # in turn that are not odd, before a dropped row is forgotten
AFTER_DROPPED = 3  # rows in which a dropped one shows as well
UNIFORM = 12.0**-0.5  # deviation of a rounding error over the step
OF_ROUNDING = 1.5  # what is left over what rounding makes: up to here it is rounding
DRAWS = 3  # replays with noise of the size of the rounding
EVALUATIONS = 30
DIFFERENCE = 1e-4  # of a parameter, for a derivative
SAME_PERIOD = 0.01  # relative difference of two periods that are one


class _Trial(NamedTuple):
    """A fault, where it is, and what the part would give with it, shape (rows, outputs)."""

    kind: str
    where: str
    predicted: Array


@dataclass(frozen=True)
class SoftwareFault:
    """
    What is wrong with a part of software.

    `kind` is what comes nearest; `is_exact` says whether the replay with it gives the measurement but for
    rounding. `before` and `after` are rms of what is left of `channel`, in its unit.
    """

    part: str
    channel: str
    kind: str
    where: str
    is_exact: bool
    before: float
    after: float

    def __str__(self) -> str:
        left = f"{self.channel} is off by {self.before:.3g} (rms)"
        if self.is_exact:
            found = f"{self.where} {self.kind}; {left}, with that {self.after:.2g}"
            return f"Fault of the software part {self.part}: {found}."
        return (
            f"Fault of the software part {self.part}: {left}; of the faults that were tried, {self.where} "
            f"{self.kind} comes nearest and leaves {self.after:.3g}."
        )

    def as_dict(self) -> dict[str, Any]:
        """Everything, ready for JSON."""
        return {
            "part": self.part,
            "channel": self.channel,
            "kind": self.kind,
            "where": self.where,
            "exact": self.is_exact,
            "rms_before": self.before,
            "rms_after": self.after,
        }


def is_software(study: Study) -> bool:
    """Whether all FMUs of a part are sampled: what drives them decides what they give, to rounding."""
    models = [study.system.model(fmu) for fmu in study.bench.part.fmus]
    return all(m is not None and m.n_continuous == 0 and m.sample_time is not None for m in models)


def ticks_between_rows(study: Study) -> list[str]:
    """FMUs of a part that tick between the rows of the recording: what drove them there is not known."""
    found = []
    for fmu in study.bench.part.fmus:
        model = study.system.model(fmu)
        if model is None or model.sample_time is None or model.n_continuous:
            continue
        start = study.system.descriptions[fmu].by_name[model.sample_time].start
        tick = float(study.system.values[fmu].get(model.sample_time, start or 0.0))
        if 0.0 < tick < study.bench.period * (1.0 - SAME_PERIOD):
            found.append(fmu)
    return found


def unknown_rows(
    study: Study,
    values: Mapping[str, float],
    predicted: Array,
    taken_off: Mapping[str, str] | None = None,
) -> str:
    """
    Say why a part of software that does not replay to rounding may have no fault; empty if it has one.

    Where few rows do not replay, those in which the recording of an input did not move and the ones after
    them, for as long as the part remembers, a logger dropped what drove it there. Where all that was recorded
    was printed short, rounding may be left.

    Args:
        study: The part.
        values: Of its parameters, by `fmu.variable`.
        predicted: Its replay with them, shape (rows, outputs).
        taken_off: Signals that are a column less another signal: their names to that signal.
    """
    rows = study.bench.in_use
    size = np.maximum(study.measured[rows].std(axis=0), TINY)
    left = np.abs(np.nan_to_num(study.measured - predicted, nan=np.inf))
    is_odd = (left > EXACT * size).any(axis=1)
    dropped = _is_dropped(study)
    left = left[rows]
    odd = is_odd[rows]
    is_rare = odd.any() and max(odd.mean(), dropped[rows].mean()) < FEW_ROWS
    if is_rare and _shows(dropped, is_odd)[rows][odd].mean() > MOST_ROWS:
        return (
            f"{100.0 * odd.mean():.2g} % of the rows do not replay, those after the beginning, or after an "
            "input was recorded as it was before; all others do: the recording lacks what drove it there"
        )
    roundings = _Roundings(study, taken_off or {})
    if not roundings.are_known:
        return ""
    changes = study.replayed_with_noise(values, roundings.of_inputs, DRAWS)[:, rows]
    rounding = np.hypot(np.sqrt(np.nanmean(changes**2, axis=(0, 1))), roundings.of_outputs)
    if np.any(np.sqrt(np.mean(left**2, axis=0)) > OF_ROUNDING * rounding):
        return ""
    return "all that was recorded of it was printed short, and what is left is that rounding"


@dataclass(frozen=True)
class _Roundings:
    """Deviations of the rounding of what was recorded of a part; those of a signal that rests are zero."""

    study: Study
    taken_off: Mapping[str, str]

    @property
    def are_known(self) -> bool:
        """Whether all that moves was recorded in steps."""
        bench = self.study.bench
        moving = [
            rounding
            for rounding, m in zip(self.of_inputs, bench.part.columns, strict=True)
            if np.ptp(bench.signal(m.signal)) > 0.0
        ]
        return bool(moving) and min(moving) > 0.0 and min(self.of_outputs) > 0.0

    @cached_property
    def of_inputs(self) -> list[float]:
        """Of each measured input."""
        bench = self.study.bench
        return [self._of(bench.signal(m.signal), m.signal) for m in bench.part.columns]

    @cached_property
    def of_outputs(self) -> list[float]:
        """Of each compared output."""
        bench = self.study.bench
        compared = bench.part.compared
        return [self._of(self.study.measured[:, i], compared[o]) for i, o in enumerate(bench.outputs)]

    def _of(self, values: Array, signal: str) -> float:
        """Of a signal (samples,) or (rows,); a difference of two has the roundings of both."""
        if signal not in self.taken_off:
            return UNIFORM * step_of(values)
        bench = self.study.bench
        other = bench.signal(self.taken_off[signal])
        if len(other) != len(values):
            other = bench.compared_rows(other)
        steps = [step_of(column) for column in (values + other, other) if np.ptp(column) > 0.0]
        return UNIFORM * float(np.hypot.reduce(steps)) if steps and min(steps) > 0.0 else 0.0


def _shows(dropped: Mask, odd: Mask) -> Mask:
    """
    Rows in which a dropped one may show, shape (rows,).

    From it on, until more rows in turn are not odd than have passed before: what rings on is not odd where it
    passes through zero. What drove a part before the first row is not recorded either.
    """
    found = dropped.copy()
    found[0] = True
    begin = 0
    last = 0
    for k in range(1, len(found)):
        if dropped[k]:
            begin = begin if found[k - 1] else k
            last = k
        elif found[k - 1] and k - last <= max(QUIET_ROWS, last - begin):
            found[k] = True
            last = k if odd[k] else last
    return found


def _is_dropped(study: Study) -> Mask:
    """Rows in which an input of a part was recorded as in the row before, and the next few, shape (rows,)."""
    bench = study.bench
    inputs = np.column_stack([bench.compared_rows(bench.signal(m.signal)) for m in bench.part.columns])
    stays = np.zeros(len(inputs), dtype=bool)
    stays[1:] = (np.diff(inputs, axis=0) == 0.0)[:, np.ptp(inputs, axis=0) > 0.0].any(axis=1)
    return np.asarray(np.convolve(stays, np.ones(1 + AFTER_DROPPED))[: len(stays)] > 0.0)


def software_fault(study: Study, values: Mapping[str, float], predicted: Array) -> SoftwareFault | None:
    """
    Find the fault that explains what a part of software leaves; None if it replays to rounding.

    Args:
        study: The part.
        values: Of its parameters, by `fmu.variable`.
        predicted: Its replay with them, shape (rows, outputs).
    """
    rows = study.bench.in_use
    measured = study.measured
    before = _left(measured, predicted, study)
    wrong = [i for i, left in enumerate(before) if left > EXACT * max(float(measured[rows, i].std()), TINY)]
    if not wrong:
        return None
    study.say("faults of software tried")
    best: _Trial | None = None
    least = np.inf
    for trial in _trials(study, values, predicted):
        left = _left(measured, trial.predicted, study)
        total = max(left[i] / before[i] for i in wrong)
        harmed = any(left[i] > 2.0 * before[i] + EXACT * measured[rows, i].std() for i in range(len(left)))
        if total < least and not harmed:
            least = total
            best = trial
        if least < NOTHING_LEFT**2:
            break
    channel = max(wrong, key=lambda i: before[i] / max(float(measured[rows, i].std()), TINY))
    kind = "has no fault of the kinds that were tried" if best is None else best.kind
    after = before[channel] if best is None else _left(measured, best.predicted, study)[channel]
    return SoftwareFault(
        part=study.name,
        channel=study.bench.outputs[channel],
        kind=kind,
        where="it" if best is None else best.where,
        is_exact=bool(least < NOTHING_LEFT),
        before=before[channel],
        after=after,
    )


def _left(measured: Array, predicted: Array, study: Study) -> list[float]:
    """Rms of what each output leaves."""
    left = (measured - predicted)[study.bench.in_use]
    return [float(v) for v in np.sqrt(np.mean(np.nan_to_num(left, nan=np.inf) ** 2, axis=0))]


def _trials(study: Study, values: Mapping[str, float], predicted: Array) -> Iterator[_Trial]:
    yield from _of_outputs(study, predicted)
    for name, own in _terms(study, values, predicted):
        yield from _of_term(name, own, study, predicted)
    yield from _of_inputs(study, values)
    yield from _of_parameters(study, values, predicted)


def _of_outputs(study: Study, predicted: Array) -> Iterator[_Trial]:
    """Faults of what the part gives, one output after the other."""
    for i, output in enumerate(study.bench.outputs):
        for kind, changed in _faults(predicted[:, i], study.measured[:, i]):
            other = predicted.copy()
            other[:, i] = changed
            yield _Trial(kind, f"the output {output}", other)


def _terms(study: Study, values: Mapping[str, float], predicted: Array) -> Iterator[tuple[str, Array]]:
    """Terms that a switch or a gain turns off: what they contribute, shape (rows, outputs)."""
    for fmu in study.bench.part.fmus:
        description = study.system.descriptions[fmu]
        for variable in description.variables:
            if variable.causality != "parameter" or variable.kind not in (Kind.BOOLEAN, Kind.INTEGER):
                continue
            key = f"{fmu}.{variable.name}"
            now = study.values_with(values)[fmu].get(variable.name, variable.start)
            is_on = str(now).lower() in ("true", "1", "1.0")
            if variable.kind is Kind.BOOLEAN:
                other = study.simulate((), dict(values) | {key: 0.0 if is_on else 1.0}, everything=True)
                term = (predicted - other) if is_on else (other - predicted)
                if np.isfinite(term).all() and np.any(term[study.bench.in_use]):
                    yield f"the term of {key}" if is_on else f"the term of {key}, which is off,", term


def _of_term(name: str, term: Array, study: Study, predicted: Array) -> Iterator[_Trial]:
    """Faults of a term that is added to the outputs."""
    if name.endswith("off,"):
        yield _Trial("is on", name, predicted + term)
        return
    yield _Trial("is missing", name, predicted - term)
    left = study.measured - (predicted - term)
    columns = [_faults(term[:, i], left[:, i]) for i in range(term.shape[1])]
    for several in zip(*columns, strict=False):
        kind = several[0].kind
        yield _Trial(kind, name, predicted - term + np.column_stack([c.values for c in several]))


class _Changed(NamedTuple):
    """A fault of a series, and the series with it, shape (rows,)."""

    kind: str
    values: Array


def _faults(series: Array, target: Array) -> Iterator[_Changed]:
    """What software may do to a series (rows,), sized by what it should be then."""
    for ticks in TICKS:
        late = "late" if ticks > 0 else "early"
        yield _Changed(f"is {_count(abs(ticks))} {late}", _shifted(series, ticks))
    yield _Changed("has the other sign", -series)
    yield _Changed("is clipped", np.clip(series, float(target.min()), float(target.max())))
    step = step_of(target)
    if step > 0.0:
        yield _Changed(f"is rounded to {step:.6g}", step * np.round(series / step))
        yield _Changed(f"is cut off to {step:.6g}", step * np.floor(series / step))
    for n in HELD:
        yield _Changed(f"is stale: held for {n} ticks", series[np.arange(len(series)) // n * n])
    power = float(series @ series)
    if power > 0.0:
        gain = float(series @ target) / power
        yield _Changed(f"has {gain:.6g} of its size", gain * series)
    offset = float(np.median(target - series))
    yield _Changed(f"is off by {offset:.6g}", series + offset)


def _of_inputs(study: Study, values: Mapping[str, float]) -> Iterator[_Trial]:
    """Faults of what drives the part."""
    bench = study.bench
    player = study.pool.player(())
    given = study.values_with(values)
    columns = bench.part.columns

    def replayed(change: Callable[[Array], Array]) -> Array:
        return bench.with_inputs(change).predict(player, given)

    for i, column in enumerate(columns):
        name = f"the input {column.signal}"
        for ticks in TICKS[:4]:
            late = "late" if ticks > 0 else "early"
            shifted = replayed(partial(_column_shifted, column=i, ticks=ticks))
            yield _Trial(f"is {_count(abs(ticks))} {late}", name, shifted)
        yield _Trial("has the other sign", name, replayed(partial(_column_scaled, column=i, factor=-1.0)))
        yield _Trial("is missing", name, replayed(partial(_column_scaled, column=i, factor=0.0)))
        for n in HELD[:3]:
            held = replayed(partial(_column_held, column=i, n=n))
            yield _Trial(f"is stale: held for {n} ticks", name, held)
    for i, j in itertools.combinations(range(len(columns)), 2):
        order = list(range(len(columns)))
        order[i] = j
        order[j] = i
        both = f"the inputs {columns[i].signal} and {columns[j].signal}"
        yield _Trial("are swapped", both, replayed(partial(np.take, indices=order, axis=1)))


def _column_shifted(table: Array, column: int, ticks: int) -> Array:
    other = table.copy()
    other[:, column] = _shifted(table[:, column], ticks)
    return other


def _column_scaled(table: Array, column: int, factor: float) -> Array:
    other = table.copy()
    other[:, column] *= factor
    return other


def _column_held(table: Array, column: int, n: int) -> Array:
    other = table.copy()
    other[:, column] = table[np.arange(len(table)) // n * n, column]
    return other


def _of_parameters(study: Study, values: Mapping[str, float], predicted: Array) -> Iterator[_Trial]:
    """One wrong number."""
    rows = study.bench.in_use
    scale = np.maximum(study.measured[rows].std(axis=0), TINY)
    for fmu in study.bench.part.fmus:
        for variable in study.system.descriptions[fmu].variables:
            if variable.causality != "parameter" or variable.kind is not Kind.REAL:
                continue
            key = f"{fmu}.{variable.name}"
            now = float(study.values_with(values)[fmu].get(variable.name, variable.start or 0.0))
            size = abs(now) or 1.0
            moved = study.simulate((), dict(values) | {key: now + DIFFERENCE * size}, everything=True)
            change = (moved - predicted)[rows]
            if not np.isfinite(change).all() or not np.any(np.abs(change) > 1e-12 * scale):
                continue

            def residual(x: Array, key: str = key, size: float = size) -> Array:
                p = study.simulate((), dict(values) | {key: float(x[0]) * size}, everything=True)
                return np.asarray(np.nan_to_num(((p - study.measured) / scale)[rows], nan=1e4).ravel())

            found = least_squares(residual, [now / size], max_nfev=EVALUATIONS, diff_step=[DIFFERENCE])
            value = float(found.x[0]) * size
            fitted = study.simulate((), dict(values) | {key: value}, everything=True)
            yield _Trial(f"is {value:.6g} instead of {now:.6g}", f"the parameter {key}", fitted)


def _shifted(series: Array, ticks: int) -> Array:
    """A series that is late, or early where ticks are negative; shape kept."""
    place = np.clip(np.arange(len(series)) - ticks, 0, len(series) - 1)
    return series[place]


def _count(ticks: int) -> str:
    return "one tick" if ticks == 1 else f"{ticks} ticks"

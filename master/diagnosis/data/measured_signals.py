"""The recordings of a case: signals in SI units, filtered and differentiated as the case says."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace
from functools import cached_property, partial

import numpy as np
import scipy  # loads its packages when they are used

from master import catalogue
from master.diagnosis.case.case import Case, DelayEntry, LoadedCase, MergeEntry, SignalEntry, TimeEntry
from master.diagnosis.case.cut import CutSystem, cut
from master.diagnosis.numerics.arrays import Array, Mask
from master.errors import ConfigError, DataError
from master.text.signal_name import SignalName

from .clock import ClockRules
from .merge import Delay, Sought, by_relation, by_shared, merged, without
from .recordings import Column, Recording, Rows, Rules, pieces_of, read_rows
from .resample import Method

ORDER = 4  # of the low-pass filter, run forwards and backwards
SHARED = "shared: "  # before the name of a signal of the first logger that the second has, too
SAME_PERIOD = 1.01  # largest sampling period over the smallest


def opened(
    loaded: LoadedCase, progress: catalogue.Progress = catalogue.silent
) -> tuple[CutSystem, dict[str, Recording]]:
    """
    Cut the system of a case and read its recordings.

    Raises:
        ConfigError: With every fault of the case, of its system and of its recordings.
    """
    problems: list[str] = list(loaded.problems)
    recordings: dict[str, Recording] = {}
    system: CutSystem | None = None
    try:
        system = cut(loaded, progress)
    except ConfigError as error:
        problems += error.problems
    try:
        recordings = measured(loaded)
    except ConfigError as error:
        problems += error.problems
    if problems or system is None:
        raise ConfigError(problems)
    return system, recordings


def measured(loaded: LoadedCase) -> dict[str, Recording]:
    """
    Read all recordings of a case.

    Raises:
        ConfigError: With every fault of every recording, each with the line of its entry.
    """
    problems: list[str] = []
    recordings: dict[str, Recording] = {}
    for name in loaded.case.recordings:
        try:
            recordings |= {r.name: r for r in _one(loaded, name)}
        except DataError as error:
            if loaded.problems and str(error).startswith("signals"):
                continue  # made of a signal that is wrong itself
            where = loaded.where("recordings", name)
            problems += [f"{where}: {line}" for line in str(error).splitlines()]
    problems += _cut(loaded, recordings)
    periods = {name: r.period for name, r in recordings.items()}
    if recordings and max(periods.values()) > SAME_PERIOD * min(periods.values()):
        problems.append(
            f"{loaded.where('recordings')}: different sampling periods, got {periods}, expected one"
        )
    if problems:
        raise ConfigError(problems)
    return recordings


def _cut(loaded: LoadedCase, recordings: Mapping[str, Recording]) -> list[str]:
    cut = loaded.case.replay.cut
    return [
        f"{loaded.where('replay', 'cut')}: got {cut} rows off both ends of {name!r}, expected fewer than "
        f"half of its {len(r)}"
        for name, r in recordings.items()
        if 2 * cut >= len(r)
    ]


def _one(loaded: LoadedCase, name: str) -> list[Recording]:
    """A recording of the case, in the pieces between its gaps."""
    case = loaded.case
    entry = case.recordings[name]
    path = loaded.file(entry)
    columns = {
        key: Column(
            entry.columns.get(key, s.column), s.unit, s.scale, s.sign, s.offset, bits=s.bits, wraps=s.range
        )
        for key, s in case.signals.items()
        if s.column is not None
    }
    is_whole = entry.rows is None
    if entry.merge is None:
        rules = Rules(
            clock=_clock_rules(case, case.time, 0.0 if is_whole else None), rates=_rates(case, columns)
        )
        rows = read_rows(path, _time(case.time), columns, rules=rules, array=entry.array, rows=entry.rows)
    else:
        rows = _merged(loaded, name, entry.merge, columns)
    resample = case.resample
    pieces = pieces_of(
        rows,
        name,
        f"{path}",
        period=None if resample is None else resample.period,
        method=None if resample is None else Method(resample.method),
    )
    given = dict(entry.set)
    told = tuple(f"set for this recording: {key} = {value:g}" for key, value in given.items())
    return [
        replace(
            piece,
            signals=_Made(case.signals, piece.signals, piece.period),
            given=given,
            notes=(*piece.notes, *told),
        )
        for piece in pieces
    ]


def _time(entry: TimeEntry) -> Column | None:
    return None if entry.column is None else Column(entry.column, entry.unit, offset=entry.offset)


def _clock_rules(case: Case, time: TimeEntry, start: float | None) -> ClockRules:
    resample = case.resample
    return ClockRules(
        period=time.period,
        start=start,
        jitter=time.jitter,
        splits=time.gaps == "split" or resample is not None,
        resampled=resample is not None,
        gap=None if resample is None else resample.gap,
        hints=True,
    )


def _merged(loaded: LoadedCase, name: str, merge: MergeEntry, columns: Mapping[str, Column]) -> Rows:
    """Rows of the first logger with the signals of the second."""
    case = loaded.case
    entry = case.recordings[name]
    time = merge.time or case.time
    first_start = 0.0 if entry.rows is None else None
    of_first = Rules(clock=_clock_rules(case, case.time, first_start))
    of_second = Rules(clock=_clock_rules(case, time, None))
    own = {key: c for key, c in columns.items() if key not in merge.signals}
    other = {key: c for key, c in columns.items() if key in merge.signals}
    shared = merge.delay.shared if isinstance(merge.delay, DelayEntry) else {}
    other |= {SHARED + key: Column(column, columns[key].unit) for key, column in shared.items()}
    problems: list[str] = []
    read: list[Rows] = []
    for file, clock, wanted, rule, array, rows in (
        (loaded.file(entry), case.time, own, of_first, entry.array, entry.rows),
        (loaded.file(merge), time, other, of_second, merge.array, None),
    ):
        try:
            read.append(read_rows(file, _time(clock), wanted, rules=rule, array=array, rows=rows))
        except DataError as error:
            problems += str(error).splitlines()
    if problems:
        raise DataError("\n".join(problems))
    first, second = read
    delay = _delay(case, name, merge, first, second)
    return merged(first, without(second, [SHARED + key for key in shared]), delay)


def _delay(case: Case, name: str, merge: MergeEntry, first: Rows, second: Rows) -> Delay:
    """The delay of the second clock as given, or found on rows that are not sealed."""
    entry = merge.delay
    if not isinstance(entry, DelayEntry):
        return Delay(entry, 0.0, "given")
    sought = Sought(entry.low, entry.high)
    if entry.shared:
        return by_shared(first, second, {key: SHARED + key for key in entry.shared}, sought)
    if name in case.split.sealed:
        raise DataError(
            "merge.delay: got bounds in a recording that is sealed, expected the delay, or a quantity "
            "that both recorded (shared): nothing is fitted to what is sealed"
        )
    return by_relation(
        first,
        second,
        lambda columns, period: _all_made(case.signals, columns, period),
        drivers=list(dict.fromkeys(e.signal for e in case.inputs.values())),
        rates=_speeds(case),
        compared=list(dict.fromkeys(case.compared.values())),
        open_rows=_open_rows(case, len(first.t)),
        sought=sought,
    )


def _speeds(case: Case) -> list[str]:
    """Signals that drive and are speeds: by the input's name, or made as the rate of what is no rate."""
    speeds = []
    for key, entry in case.inputs.items():
        variable = SignalName(key).variable
        made_of = case.signals[entry.signal].rate_of if entry.signal in case.signals else None
        is_rate = made_of is not None
        is_first = is_rate and (made_of not in case.signals or case.signals[made_of].rate_of is None)
        is_named = variable.startswith(("der_", "v_")) and not variable.startswith("der_der_")
        if (is_first or is_named) and entry.signal not in speeds:
            speeds.append(entry.signal)
    return speeds


def _open_rows(case: Case, n: int) -> Mask:
    """Rows outside the sealed blocks."""
    is_open = np.ones(n, dtype=bool)
    uses = case.split.blocks or []
    for i, use in enumerate(uses):
        if use == "sealed":
            is_open[n * i // len(uses) : n * (i + 1) // len(uses)] = False
    return is_open


class _Made(Mapping[str, Array]):
    """
    All signals of a case on the rows of a recording, made when the first is asked for: a check asks for none.

    Raises:
        DataError: At once, where they cannot be made.
    """

    def __init__(
        self, signals: Mapping[str, SignalEntry], columns: Mapping[str, Array], period: float
    ) -> None:
        self._names = _ordered(signals)
        for name in self._names:
            _check_low_pass(signals[name], period, name)
        self._make = partial(_all_made, signals, columns, period)

    @cached_property
    def _values(self) -> dict[str, Array]:
        return self._make()

    def __getitem__(self, name: str) -> Array:
        return self._values[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._names)

    def __len__(self) -> int:
        return len(self._names)


def _all_made(
    signals: Mapping[str, SignalEntry], columns: Mapping[str, Array], period: float
) -> dict[str, Array]:
    """All signals of a case from those with a column."""
    made: dict[str, Array] = {}
    for key in _ordered(signals):
        made[key] = _made(signals[key], columns, period, made, key)
    return made


def _rates(case: Case, columns: Mapping[str, Column]) -> dict[str, str]:
    """Signals whose rate was recorded too: inputs of one FMU by names like q and der_q, s_act and v_act."""
    rates = {}
    for key, entry in case.inputs.items():
        fmu, name = SignalName(key).parts
        for rate in (f"der_{name}", "v_" + name.removeprefix("s_")):
            other = case.inputs.get(f"{fmu}.{rate}")
            if other is not None and {entry.signal, other.signal} <= set(columns):
                rates[entry.signal] = other.signal
    return rates


def _ordered(signals: Mapping[str, SignalEntry]) -> list[str]:
    """Names with what they are made from before them; a ring of names keeps its order."""
    done: list[str] = []
    for _ in signals:
        for name, s in signals.items():
            if name not in done and all(n is None or n in done for n in (s.minus, s.rate_of)):
                done.append(name)
    missing = [name for name in signals if name not in done]
    if missing:
        raise DataError(f"signals: made from each other, got {missing}, expected a column at the end")
    return done


def _made(
    entry: SignalEntry, columns: Mapping[str, Array], period: float, made: Mapping[str, Array], name: str
) -> Array:
    values = np.gradient(made[entry.rate_of], period) if entry.rate_of else columns[name]
    if entry.minus is not None:
        values = values - made[entry.minus]
    if entry.remove_mean:
        values = values - values.mean()
    if entry.lowpass is not None:
        _check_low_pass(entry, period, name)
        low_pass = scipy.signal.butter(ORDER, entry.lowpass, fs=1.0 / period)
        values = scipy.signal.filtfilt(*low_pass, values)
    return np.asarray(values, dtype=float)


def _check_low_pass(entry: SignalEntry, period: float, name: str) -> None:
    """Raise DataError where a low-pass filter is at half of the sampling rate or above."""
    half = 0.5 / period
    if entry.lowpass is not None and entry.lowpass >= half:
        raise DataError(
            f"signals.{name}.lowpass: got {entry.lowpass:g} Hz, expected less than {half:g} Hz, half the "
            "sampling rate"
        )

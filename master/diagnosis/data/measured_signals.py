"""The recordings of a case: signals in SI units, filtered and differentiated as the case says."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from scipy.signal import butter, filtfilt

from master import catalogue
from master.diagnosis.case.case import Case, LoadedCase, SignalEntry
from master.diagnosis.case.cut import CutSystem, cut
from master.diagnosis.numerics.arrays import Array
from master.errors import ConfigError, DataError
from master.text.signal_name import SignalName

from .recordings import Column, Recording, Rules, read

ORDER = 4  # of the low-pass filter, run forwards and backwards
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
            recordings[name] = _one(loaded, name)
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


def _one(loaded: LoadedCase, name: str) -> Recording:
    case = loaded.case
    entry = case.recordings[name]
    columns = {
        key: Column(entry.columns.get(key, s.column), s.unit, s.scale, s.sign, s.offset)
        for key, s in case.signals.items()
        if s.column is not None
    }
    t = case.time
    time = None if t.column is None else Column(t.column, t.unit, offset=t.offset)
    rules = Rules(
        period=t.period, start=None if entry.rows else 0.0, jitter=t.jitter, rates=_rates(case, columns)
    )
    table = read(loaded.file(entry), time, columns, rules=rules, array=entry.array, rows=entry.rows)
    signals: dict[str, Array] = {}
    for key in _ordered(case.signals):
        signals[key] = _made(case.signals[key], table, signals, key)
    return Recording(name, table.t, signals, table.period)


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


def _made(entry: SignalEntry, columns: Recording, made: Mapping[str, Array], name: str) -> Array:
    values = np.gradient(made[entry.rate_of], columns.period) if entry.rate_of else columns[name]
    if entry.minus is not None:
        values = values - made[entry.minus]
    if entry.remove_mean:
        values = values - values.mean()
    if entry.lowpass is not None:
        half = 0.5 / columns.period
        if entry.lowpass >= half:
            raise DataError(
                f"signals.{name}.lowpass: got {entry.lowpass:g} Hz, expected less than {half:g} Hz, half the "
                "sampling rate"
            )
        values = filtfilt(*butter(ORDER, entry.lowpass, fs=1.0 / columns.period), values)
    return np.asarray(values, dtype=float)

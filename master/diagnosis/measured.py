"""The recordings of a case: signals in SI units, filtered and differentiated as the case says."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from scipy.signal import butter, filtfilt

from ..errors import ConfigError, DataError
from .case import LoadedCase, SignalEntry
from .recordings import Column, Recording, Rules, read
from .tables import Array

ORDER = 4


def measured(loaded: LoadedCase) -> dict[str, Recording]:
    """
    Read all recordings of a case.

    Raises:
        ConfigError: With every fault of every recording, each with the line of its entry.
    """
    problems: list[str] = []
    found: dict[str, Recording] = {}
    for name in loaded.case.recordings:
        try:
            found[name] = _one(loaded, name)
        except DataError as error:
            where = loaded.where("recordings", name)
            problems += [f"{where}: {line}" for line in str(error).splitlines()]
    periods = {name: r.period for name, r in found.items()}
    if found and max(periods.values()) > 1.01 * min(periods.values()):
        problems.append(
            f"{loaded.where('recordings')}: different sampling periods, got {periods}, expected one"
        )
    if problems:
        raise ConfigError(problems)
    return found


def _one(loaded: LoadedCase, name: str) -> Recording:
    case, entry = loaded.case, loaded.case.recordings[name]
    columns = {
        key: Column(s.column, s.unit, s.scale, s.sign, s.offset)
        for key, s in case.signals.items()
        if s.column is not None
    }
    t = case.time
    time = None if t.column is None else Column(t.column, t.unit, offset=t.offset)
    rules = Rules(period=t.period, start=None if entry.rows else 0.0, jitter=t.jitter)
    found = read(loaded.file(entry), time, columns, rules=rules, array=entry.array, rows=entry.rows)
    signals: dict[str, Array] = {}
    for key in _ordered(case.signals):
        signals[key] = _made(case.signals[key], found, signals, key)
    return Recording(name, found.t, signals, found.period)


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


def _made(entry: SignalEntry, found: Recording, made: Mapping[str, Array], name: str) -> Array:
    values = np.gradient(made[entry.rate_of], found.period) if entry.rate_of else found[name]
    if entry.minus is not None:
        values = values - made[entry.minus]
    if entry.remove_mean:
        values = values - values.mean()
    if entry.lowpass is not None:
        values = filtfilt(*butter(ORDER, entry.lowpass, fs=1.0 / found.period), values)
    return np.asarray(values, dtype=float)

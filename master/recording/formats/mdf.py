"""ASAM MDF files (measurement data format, versions 3 and 4), by asammdf."""

from __future__ import annotations

import math
from collections import Counter
from pathlib import Path
from typing import Any

import numpy as np

from .table import NUMBERS, Table, by_columns, library


def read_mdf(path: Path, _: str | None) -> Table:
    """
    Read all channels in physical values.

    A channel keeps its name; where several groups have one of it, it is `group.name`, groups counted from 0.
    The clock of a group is `time`, `0.time`, `1.time`, ... where there are several groups. Samples that the
    file marks as invalid are NaN.
    """
    asammdf = library("asammdf", "asammdf", path)
    with asammdf.MDF(path) as file:
        groups = [
            [_signal(file, i, j) for j in range(len(group.channels)) if j != file.masters_db.get(i)]
            for i, group in enumerate(file.groups)
        ]
    used = [(i, signals) for i, signals in enumerate(groups) if signals]
    names = Counter(signal.name for _, signals in used for signal in signals)
    columns: dict[str, Any] = {}
    units: dict[str, str] = {}
    clocks: dict[str, str] = {}
    for i, signals in used:
        clock = "time" if len(used) == 1 and "time" not in names else f"{i}.time"
        columns[clock] = signals[0].timestamps
        clocks[clock] = clock
        units[clock] = "s"
        for signal in signals:
            key = signal.name if names[signal.name] == 1 else f"{i}.{signal.name}"
            columns[key] = _samples(signal)
            units[key] = signal.unit or ""
            clocks[key] = clock
    table = by_columns(path, columns)
    table.units = {key: unit for key, unit in units.items() if unit}
    table.clocks = clocks
    return table


def _signal(file: Any, group: int, index: int) -> Any:
    return file.get(group=group, index=index, ignore_invalidation_bits=True)


def _samples(signal: Any) -> Any:
    samples = np.asarray(signal.samples)
    if samples.dtype.names or samples.ndim != 1:
        return np.full(len(samples), "array")
    if signal.invalidation_bits is None or samples.dtype.kind not in NUMBERS:
        return samples
    return np.where(np.asarray(signal.invalidation_bits, dtype=bool), math.nan, samples)

"""TDMS files of LabVIEW, by npTDMS."""

from __future__ import annotations

from collections import Counter
from pathlib import Path
from typing import Any

from .table import Table, by_columns, library

_STEP = "wf_increment"  # property of a channel that carries its clock


def read_tdms(path: Path, _: str | None) -> Table:
    """
    Read all channels, scaled as the file says.

    A channel keeps its name; where several groups have one of it, it is `group/name`. A channel with a clock
    of its own adds the column `<channel>.time`.
    """
    nptdms = library("nptdms", "npTDMS", path)
    with nptdms.TdmsFile.open(path) as file:
        channels = [channel for group in file.groups() for channel in group.channels()]
        names = Counter(channel.name for channel in channels)
        columns: dict[str, Any] = {}
        units: dict[str, str] = {}
        clocks: dict[str, str] = {}
        for channel in channels:
            is_unique = names[channel.name] == 1
            key = channel.name if is_unique else f"{channel.group_name}/{channel.name}"
            columns[key] = channel[:]
            units[key] = str(channel.properties.get("unit_string", ""))
            if _STEP in channel.properties:
                columns[f"{key}.time"] = channel.time_track()
                units[f"{key}.time"] = "s"
                clocks |= {key: f"{key}.time", f"{key}.time": f"{key}.time"}
    table = by_columns(path, columns)
    table.units = {key: unit for key, unit in units.items() if unit}
    table.clocks = clocks
    return table

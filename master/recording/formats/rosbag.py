"""
Bags of ROS 1 (`.bag`) and ROS 2 (a folder with `metadata.yaml`), by rosbags.

A number of a message is the column `/topic/field.field`, an entry of an array `/topic/field.0`. `/topic/time`
is when a message was recorded, and `/topic/header.stamp` what it says of itself: both in seconds since the
begin of the bag.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from .table import NANOSECONDS, Table, by_columns, library

METADATA = "metadata.yaml"
_LONGEST_ARRAY = 64  # entries that become columns: images and clouds of points do not


def read_bag(path: Path, _: str | None) -> Table:
    """Read the numbers of all messages, a topic's columns as long as it has messages."""
    highlevel = library("rosbags.highlevel", "rosbags", path)
    typesys = library("rosbags.typesys", "rosbags", path)
    if path.suffix in (".db3", ".mcap"):
        if not (path.parent / METADATA).is_file():
            raise ValueError(f"no {METADATA} next to it, expected the folder of the bag")
        path = path.parent
    rows: dict[str, list[dict[str, float]]] = {}
    store = typesys.get_typestore(typesys.Stores.LATEST)
    with highlevel.AnyReader([path], default_typestore=store) as reader:
        begin = reader.start_time
        for connection, time, raw in reader.messages():
            message = reader.deserialize(raw, connection.msgtype)
            row = {"time": (time - begin) / NANOSECONDS, **dict(_numbers(message, "", begin))}
            rows.setdefault(connection.topic, []).append(row)
    columns: dict[str, Any] = {}
    for topic, messages in rows.items():
        for key in _keys(messages):
            columns[f"{topic}/{key}"] = np.array([row.get(key, np.nan) for row in messages])
    table = by_columns(path, columns)
    table.units = {key: "s" for key in columns if key.endswith(("/time", ".stamp"))}
    table.clocks = {f"{topic}/{key}": f"{topic}/time" for topic in rows for key in _keys(rows[topic])}
    return table


def _keys(messages: Sequence[Mapping[str, float]]) -> list[str]:
    return list(dict.fromkeys(key for row in messages for key in row))


def _numbers(message: Any, prefix: str, begin: int) -> Iterator[tuple[str, float]]:
    for field in dataclasses.fields(message):
        if field.name.startswith("__"):
            continue
        value = getattr(message, field.name)
        key = f"{prefix}{field.name}"
        if hasattr(value, "sec") and hasattr(value, "nanosec"):
            whole = int(value.sec) * NANOSECONDS + int(value.nanosec)
            is_date = field.name == "stamp"
            yield key, (whole - begin if is_date else whole) / NANOSECONDS
        elif dataclasses.is_dataclass(value):
            yield from _numbers(value, f"{key}.", begin)
        elif isinstance(value, (bool, int, float, np.number, np.bool_)):
            yield key, float(value)
        elif isinstance(value, np.ndarray) and value.ndim == 1 and len(value) <= _LONGEST_ARRAY:
            yield from ((f"{key}.{i}", float(entry)) for i, entry in enumerate(value))

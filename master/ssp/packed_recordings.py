"""Which recordings an archive holds, and which of them are components of the system."""

from __future__ import annotations

import re
from collections.abc import Collection, Mapping
from dataclasses import dataclass, field
from pathlib import Path

from master.errors import ConfigError
from master.fmi.description import Kind
from master.system.config import InputFile

from .prepared import PreparedSystem
from .table_header import time_column

_SAFE = re.compile(r"(?:[\w-][\w. -]*/)*[\w-][\w. -]*\.\w+", re.ASCII)


@dataclass(frozen=True)
class PackedRecordings:
    """
    Recordings of an archive.

    `members` and `contents` are by the names that the system has for the files; `components` are those that
    are components, by their names there; `in_components` are the numbers of their entries of `inputs`.
    """

    members: Mapping[str, str] = field(default_factory=dict)
    contents: Mapping[str, bytes] = field(default_factory=dict)
    components: Mapping[str, str] = field(default_factory=dict)
    in_components: frozenset[int] = frozenset()


def pack_recordings(experiment: PreparedSystem, taken: Collection[str]) -> PackedRecordings:
    """
    Read the recordings of a system and find names for them in an archive that are not `taken`.

    Raises:
        ConfigError: If one cannot be read.
    """
    contents: dict[str, bytes] = {}
    for name, path in experiment.inputs.files.items():
        try:
            contents[name] = path.read_bytes()
        except OSError as error:
            raise ConfigError([f"{name}: cannot be read, got {error.strerror}"]) from None
    members: dict[str, str] = {}
    for name, path in experiment.inputs.files.items():
        members[name] = _member(name, path, {*taken, *members.values()})
    components: dict[str, str] = {}
    entries: set[int] = set()
    for owner in experiment.system.connectors:
        own = _entries_of(experiment, owner, contents)
        if own:
            components[owner] = experiment.config.inputs[own[0]].file
            entries |= set(own)
    return PackedRecordings(members, contents, components, frozenset(entries))


def _member(name: str, path: Path, taken: Collection[str]) -> str:
    """Name of a file in the archive: its own where that can be."""
    lower = {one.lower() for one in taken}
    if _SAFE.fullmatch(name) and ".." not in name.split("/") and name.lower() not in lower:
        return name
    n = 1
    while (found := f"resources/recording_{n}{path.suffix.lower()}") in lower:
        n += 1
    return found


def _entries_of(experiment: PreparedSystem, owner: str, contents: Mapping[str, bytes]) -> list[int]:
    """Entries of `inputs` that a component of a recording says as well; none where one says more."""
    variables = experiment.system.connectors[owner].by_name
    columns: set[str] = set()
    entries: list[int] = []
    for i, given in enumerate(experiment.config.inputs):
        own = {signal.partition(".")[2] for signal in given.map if signal.partition(".")[0] == owner}
        if not own:
            continue
        if len(own) < len(given.map) or not _is_plain(given, contents[given.file]):
            return []
        is_linear = given.interpolation == "linear"
        if any((variables[name].kind is Kind.REAL) != is_linear for name in own):
            return []
        columns |= own
        entries.append(i)
    files = {experiment.config.inputs[i].file for i in entries}
    return entries if len(files) == 1 and columns == set(variables) else []


def _is_plain(given: InputFile, content: bytes) -> bool:
    """Whether a component of a recording says all that is said of a file."""
    names = all(signal.partition(".")[2] == c.column and c.unit is None for signal, c in given.map.items())
    is_csv = given.file.lower().endswith(".csv")
    is_time = is_csv and given.time.column == time_column(content) and given.time.unit in (None, "s")
    return names and is_time and given.array is None and given.at == "start"

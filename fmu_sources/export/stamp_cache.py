"""
Stamps of models, kept on disk until any source changes.

A stamp is a digest of all sources of an FMU; to find those, modules are parsed and equations traced. What
was found holds as long as path, size, and times of modification and of change of every file here are the
same. Where nothing can be written, stamps are computed each time.
"""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Callable, Iterator
from contextlib import suppress
from pathlib import Path

from .places import cache_folder
from .whole_file import write_whole

_SOURCES = Path(__file__).parents[1]


class StampCache:
    """Stamps by the names of models, in a file; good for the sources as they are when it is made."""

    def __init__(self, file: Path | None = None, sources: Path = _SOURCES) -> None:
        self._file = file or _file_of(sources)
        self._state = _state_of(sources)
        self._stamps = self._read()

    def stamp(self, name: str, compute: Callable[[], str]) -> str:
        """Return the stamp of a model as it is kept, or compute it and keep it."""
        if name not in self._stamps:
            self._stamps[name] = compute()
            self._write()
        return self._stamps[name]

    def _read(self) -> dict[str, str]:
        try:
            content = json.loads(self._file.read_bytes())
            return dict(content["stamps"]) if content["sources"] == self._state else {}
        except (OSError, ValueError, TypeError, KeyError):
            return {}

    def _write(self) -> None:
        content = json.dumps({"sources": self._state, "stamps": self._stamps}, indent=2)
        with suppress(OSError):
            write_whole(self._file, content.encode() + b"\n")


def _file_of(sources: Path) -> Path:
    """Place of the stamps of a copy of the sources: copies share the cache."""
    copy = hashlib.sha256(os.fsencode(sources)).hexdigest()[:16]
    return cache_folder() / "stamps" / f"{copy}.json"


def _state_of(sources: Path) -> str:
    """Digest of what the file system says of all sources."""
    lines = sorted(_lines(str(sources)))
    return hashlib.sha256("\n".join(lines).encode("utf-8", "surrogateescape")).hexdigest()


def _lines(folder: str) -> Iterator[str]:
    with os.scandir(folder) as entries:
        for entry in entries:
            if entry.is_dir():
                if entry.name != "__pycache__":
                    yield from _lines(entry.path)
                continue
            state = entry.stat()
            yield f"{entry.path} {state.st_size} {state.st_mtime_ns} {state.st_ctime_ns}"

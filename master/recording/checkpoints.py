"""
The files of a checkpoint in a results folder: what is needed to go on is on the disk before it is announced.

`checkpoint` has a line of JSON (the `Mark` of the result files, size and SHA-256 of what follows) and then
the state of the run. `checkpoint.rows` has the rows that the run keeps in memory, as doubles in the order of
this machine's bytes; it only grows. A checkpoint replaces the one before it in one move, when rows and result
files up to it have reached the disk: whenever the process or the machine ends, the last one is whole.
"""

from __future__ import annotations

import hashlib
import json
import os
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from master.errors import DataError

from .files import FilesMark, ResultFiles
from .folder import CHECKPOINT, CHECKPOINT_ROWS
from .whole_file import sync_folder, write_whole

Floats = NDArray[np.float64]

_FORMAT = 1


@dataclass(frozen=True)
class Mark:
    """How far rows had come: all of the run, those kept in memory, and those in the result files."""

    n_rows: int
    n_kept: int
    files: FilesMark


@dataclass(frozen=True)
class Checkpoint:
    """A checkpoint as it was read: its mark, the kept rows of shape (n_kept, signals), the run's state."""

    mark: Mark
    kept: Floats
    state: bytes


class CheckpointFiles:
    """Writes the checkpoints of a run; methods raise OSError where the disk does not take them."""

    def __init__(self, folder: Path, n_kept: int = 0) -> None:
        """Write into a folder whose `checkpoint.rows`, if it is there, holds `n_kept` rows or more."""
        self._folder = folder
        self._n_kept = n_kept

    def save(self, mark: Mark, kept: Floats, state: bytes) -> None:
        """Make a checkpoint; `kept` are all rows that the run keeps in memory, shape (n_kept, signals)."""
        with (self._folder / CHECKPOINT_ROWS).open("r+b" if self._n_kept else "w+b", buffering=0) as file:
            new = np.ascontiguousarray(kept[self._n_kept : mark.n_kept])
            file.truncate(8 * self._n_kept * kept.shape[1])
            file.seek(0, os.SEEK_END)
            rest = memoryview(new.tobytes())
            while len(rest):
                rest = rest[file.write(rest) :]
            os.fsync(file.fileno())
        sync_folder(self._folder)
        head = {
            "format": _FORMAT,
            **asdict(mark),
            "n_signals": kept.shape[1],
            "n_bytes": len(state),
            "sha256": hashlib.sha256(state).hexdigest(),
        }
        write_whole(self._folder / CHECKPOINT, json.dumps(head).encode() + b"\n" + state, is_durable=True)
        self._n_kept = mark.n_kept


def read_checkpoint(folder: Path) -> Checkpoint | None:
    """
    Read the last checkpoint of a results folder, None if there is none yet.

    Raises:
        DataError: If it is damaged or of another format.
    """
    path = folder / CHECKPOINT
    try:
        line, _, state = path.read_bytes().partition(b"\n")
    except FileNotFoundError:
        return None
    except OSError as error:
        raise DataError(f"{path}: cannot be read: {error.strerror}") from None
    try:
        head = json.loads(line)
        if head["format"] != _FORMAT:
            raise DataError(f"{path}: format, got {head['format']!r}, expected {_FORMAT}")
        if len(state) != head["n_bytes"] or hashlib.sha256(state).hexdigest() != head["sha256"]:
            raise DataError(f"{path}: is damaged: its content does not have the hash that its head names")
        mark = Mark(int(head["n_rows"]), int(head["n_kept"]), FilesMark(**head["files"]))
        n_signals = int(head["n_signals"])
    except (ValueError, KeyError, TypeError):
        raise DataError(f"{path}: cannot be read as a checkpoint, expected a file that a run wrote") from None
    return Checkpoint(mark, _read_kept(folder / CHECKPOINT_ROWS, mark.n_kept, n_signals), state)


def _read_kept(path: Path, n: int, n_signals: int) -> Floats:
    try:
        found = np.fromfile(path, np.float64, n * n_signals)
    except OSError as error:
        raise DataError(f"{path}: cannot be read: {error.strerror}") from None
    if len(found) < n * n_signals:
        got = len(found) // max(1, n_signals)
        raise DataError(f"{path}: is too short, got {got} rows, expected {n}")
    return found.reshape(n, n_signals)


def remove_checkpoint(folder: Path) -> None:
    """Remove what is of no use after a run has come to its end; OSError if that cannot be."""
    for name in (CHECKPOINT, CHECKPOINT_ROWS):
        (folder / name).unlink(missing_ok=True)


@dataclass(frozen=True)
class Durable:
    """
    Checkpoints of a run: each `interval` [s], into `files`, up to which the result files are written too.

    `begin_at` is the one that the run goes on from.
    """

    interval: float
    files: CheckpointFiles
    results: ResultFiles
    begin_at: Checkpoint | None = None

"""The folder of a run: made and tested before it, held by one run at a time, with nothing old in it."""

from __future__ import annotations

import os
from pathlib import Path
from types import TracebackType

from master.errors import DataError

from .lock import FileLock, Held

SUMMARY, PICTURE, LOG = "summary.json", "displacement_and_force.png", "fmu.log"
CSV, PARQUET, PARTS = "result.csv", "result.parquet", "result.part-*.parquet"

_RESERVE = 65536  # bytes that the lock occupies, so that a full disk has room for the summary


class OutputFolder:
    """
    A folder that belongs to one run until it is closed.

    Raises:
        DataError: If it cannot be made or written, or another run writes there.
    """

    def __init__(self, path: Path) -> None:
        self.path = path.absolute()
        self.shown = path
        try:
            path.mkdir(parents=True, exist_ok=True)
            self._lock = FileLock(path / ".dockloop.lock", _RESERVE)
            self._remove_old()
        except Held as held:
            raise DataError(
                f"{path}: another run writes here, got process {held.pid}, expected a folder of its own"
            ) from None
        except (OSError, ValueError) as error:
            raise DataError(f"{path}: cannot be written: {reason(error)}") from None
        self._identity = _identity(path)

    def vanished(self) -> bool:
        """Whether the folder was removed or replaced since it was made."""
        return _identity(self.path) != self._identity

    def restore(self) -> None:
        """Make the folder again where it has vanished; OSError if that cannot be."""
        self.path.mkdir(parents=True, exist_ok=True)
        self._identity = _identity(self.path)

    def make_room(self) -> None:
        """Give back the bytes that were kept for the summary."""
        self._lock.empty()

    def __enter__(self) -> OutputFolder:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._lock.release()

    def _remove_old(self) -> None:
        """Remove the results of an older run, the summary first."""
        for name in (SUMMARY, PICTURE, LOG, CSV, PARQUET):
            (self.path / name).unlink(missing_ok=True)
        for part in self.path.glob(PARTS):
            part.unlink()


def reason(error: BaseException) -> str:
    """Say what the system says of a file, without the file's name."""
    text = getattr(error, "strerror", None) or str(error)
    return str(text).partition(". Detail: ")[0]


def _identity(path: Path) -> tuple[int, int] | None:
    try:
        found = os.stat(path)
    except OSError:
        return None
    return found.st_dev, found.st_ino

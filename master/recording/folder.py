"""The folder of a run: made and tested before it, held by one run at a time, with nothing old in it."""

from __future__ import annotations

import contextlib
import os
from pathlib import Path
from types import TracebackType

from master.errors import DataError

from .lock import FileLock, Held

SUMMARY, PICTURE, LOG = "summary.json", "plots.png", "fmu.log"
MANIFEST, PAGE = "manifest.json", "run.html"
CSV, PARQUET, PARTS = "result.csv", "result.parquet", "result.part-*.parquet"
CHECKPOINT, CHECKPOINT_ROWS = "checkpoint", "checkpoint.rows"
_UNFINISHED = (".*.new", "*.partial")  # left by a process that was killed

RESCUED = "-rescued"  # after the name of a folder that takes no files any more

_RESERVE = 65536  # bytes that the lock occupies, so that a full disk has room for the summary


class OutputFolder:
    """
    A folder that belongs to one run until it is closed.

    Raises:
        DataError: If it cannot be made or written, or another run writes there.
    """

    def __init__(self, path: Path, *, goes_on: bool = False) -> None:
        """Take the folder, empty but for a run that `goes_on`: that keeps its rows and its checkpoint."""
        self.path = path.absolute()
        self.shown = path
        try:
            path.mkdir(parents=True, exist_ok=True)
            self._lock = FileLock(path / ".dockloop.lock")
            self._remove_old(goes_on)  # before the rest: an old result may fill the disk
            self._lock.fill(_RESERVE)
        except Held as held:
            raise DataError(
                f"{path}: another run writes here, got process {held.pid}, expected a folder of its own"
            ) from None
        except (OSError, ValueError) as error:
            raise DataError(f"{path}: cannot be written: {reason(error)}") from None
        self._first = self.path.resolve()
        self._identity = _identity(path)

    def vanished(self) -> bool:
        """Whether the folder was removed or replaced since it was made."""
        return _identity(self.path) != self._identity

    def takes_files(self) -> bool:
        """Whether it is there still, and lets files be made in it."""
        return not self.vanished() and os.access(self.path, os.W_OK | os.X_OK)

    def secure(self) -> None:
        """
        Find a place for what was computed: the folder made again where it has vanished, or one next to it.

        Raises:
            OSError: If neither can be made.
        """
        if self.vanished():
            with contextlib.suppress(OSError):
                self.path.mkdir(parents=True, exist_ok=True)
                self._identity = _identity(self.path)
        n = 1
        while not self.takes_files():
            number = "" if n == 1 else f"-{n}"
            beside = self._first.with_name(f"{self._first.name}{RESCUED}{number}")
            n += 1
            with contextlib.suppress(FileExistsError):
                beside.mkdir(parents=True)
                self.path = self.shown = beside
                self._identity = _identity(beside)

    def make_room(self) -> None:
        """Give back the bytes that were kept for the summary."""
        self._lock.empty()

    def __enter__(self) -> OutputFolder:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._lock.release()

    def _remove_old(self, goes_on: bool) -> None:
        """Remove the results of an older run, the summary first."""
        of_the_end = (SUMMARY, PAGE, PICTURE)
        of_the_way = (CHECKPOINT, CHECKPOINT_ROWS, MANIFEST, LOG, CSV, PARQUET)
        for name in of_the_end if goes_on else (*of_the_end, *of_the_way):
            (self.path / name).unlink(missing_ok=True)
        for pattern in _UNFINISHED if goes_on else (*_UNFINISHED, PARTS):
            for file in self.path.glob(pattern):
                file.unlink(missing_ok=True)


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

"""A file that one process holds; the system lets go of it when the process ends, however it ends."""

from __future__ import annotations

import contextlib
import errno
import os
import time
from pathlib import Path
from typing import Any

try:
    import fcntl

    def _take(descriptor: int) -> None:
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)

    def _has_ended(pid: str) -> bool:
        try:
            os.kill(int(pid), 0)
        except (ValueError, OSError) as error:
            return isinstance(error, ProcessLookupError)
        return False

except ImportError:  # Windows
    import msvcrt

    _windows: Any = msvcrt

    def _take(descriptor: int) -> None:
        _windows.locking(descriptor, _windows.LK_NBLCK, 1)

    def _has_ended(pid: str) -> bool:
        return False


_PATIENCE_SECONDS = 10.0  # until the children of a killed process have ended, on a busy machine too
_LOOK_SECONDS = 0.02


class Held(Exception):  # noqa: N818 - says who holds the file
    """Another process holds the file; `pid` says which, as far as it wrote that."""

    def __init__(self, pid: str) -> None:
        self.pid = pid
        super().__init__(pid)


class FileLock:
    """
    Hold a file, which begins with the process's number in a line.

    A file that a process left when it was killed is taken, once the children that ended with it are gone too.

    Raises:
        Held: If another process has it.
        OSError: If it cannot be written.
    """

    def __init__(self, path: Path) -> None:
        self._path = path
        self._descriptor = -1
        until = time.monotonic() + _PATIENCE_SECONDS
        while self._descriptor < 0:
            try:
                self._descriptor = _held(path)
            except Held as held:
                if not _has_ended(held.pid) or time.monotonic() > until:
                    raise
                time.sleep(_LOOK_SECONDS)

    def fill(self, n_bytes: int) -> None:
        """Make the file n_bytes long; OSError, and nobody holds it, if there is no room for them."""
        try:
            os.ftruncate(self._descriptor, 0)
            text = f"{os.getpid()}\n".encode().ljust(n_bytes)
            written = os.write(self._descriptor, text)
            if written < n_bytes:
                raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        except OSError:
            self.release()
            raise

    def empty(self) -> None:
        """Give back the bytes; the file stays held."""
        os.ftruncate(self._descriptor, 0)

    def release(self) -> None:
        """Let go, and remove the file where its folder still allows that."""
        with contextlib.suppress(OSError):
            self._path.unlink(missing_ok=True)
        os.close(self._descriptor)


def _held(path: Path) -> int:
    """Open and take the file; -1 if its holder removed it meanwhile."""
    descriptor = os.open(path, os.O_RDWR | os.O_CREAT, 0o666)
    try:
        _take(descriptor)
        if os.path.samestat(os.fstat(descriptor), os.stat(path)):
            return descriptor
    except FileNotFoundError:
        pass
    except OSError:
        pid = os.read(descriptor, 20).split(b"\n")[0].decode(errors="replace").strip()
        os.close(descriptor)
        raise Held(pid or "unknown") from None
    os.close(descriptor)
    return -1

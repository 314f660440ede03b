"""Files that no reader sees half written; where it matters, on the disk before they have their names."""

from __future__ import annotations

import contextlib
import errno
import os
import tempfile
from collections.abc import Iterator
from pathlib import Path


def write_whole(path: Path, content: str | bytes, *, is_durable: bool = False) -> None:
    """
    Write a file in one move; its folder is made where it is missing.

    Args:
        path: The file.
        content: What it holds then.
        is_durable: Whether it has to be there after a power cut too, which costs some 10 ms.

    Raises:
        OSError: If it cannot be written; what was at `path` before is there still, and nothing else.
    """
    path.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.NamedTemporaryFile(dir=path.parent, suffix=".partial", delete=False) as partial:
        written = Path(partial.name)
    try:
        written.write_bytes(content.encode() if isinstance(content, str) else content)
        written.chmod(0o644)
        _move(written, path, is_durable)
    except BaseException:
        with contextlib.suppress(OSError):
            written.unlink(missing_ok=True)
        raise


@contextlib.contextmanager
def appearing(path: Path, *, is_durable: bool = False) -> Iterator[Path]:
    """Write a file under another name first: under its own it is complete, or it is not there."""
    new = path.with_name(f".{path.name}.new")
    try:
        yield new
        _move(new, path, is_durable)
    finally:
        with contextlib.suppress(OSError):
            new.unlink(missing_ok=True)


def _move(written: Path, path: Path, is_durable: bool) -> None:
    if is_durable:
        sync_file(written)
    written.replace(path)
    if is_durable:
        sync_folder(path.parent)


def sync_file(path: Path) -> None:
    """Let the content of a file reach the disk; OSError if it does not."""
    with path.open("r+b") as file:
        os.fsync(file.fileno())


def sync_folder(folder: Path) -> None:
    """Let the names in a folder reach the disk, where the system can do that; OSError if it fails."""
    if not hasattr(os, "O_DIRECTORY"):
        return
    descriptor = os.open(folder, os.O_RDONLY | os.O_DIRECTORY)
    try:
        os.fsync(descriptor)
    except OSError as error:
        if error.errno != errno.EINVAL:  # a file system that has nothing to do there
            raise
    finally:
        os.close(descriptor)

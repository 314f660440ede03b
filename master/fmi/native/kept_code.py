"""Compiled code that numba keeps on disk between processes: where, of which sources, whether it is whole."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

_CHECKED = ".sha256"


def digest_of(sources: Sequence[Path]) -> int:
    """Digest of files, 63 bits."""
    texts = [source.read_bytes() for source in sources]
    return int.from_bytes(hashlib.sha256(b"\0".join(texts)).digest()[:8], "big") >> 1


@contextmanager
def kept_in(folder: Path, key: str = "") -> Iterator[None]:
    """
    Let numba keep what is compiled within the block in a folder, or where NUMBA_CACHE_DIR says.

    Code that is kept under another key is not found.
    """
    from numba import config

    settings: Any = config
    of_the_user = settings.CACHE_DIR  # for all that this process compiles
    settings.CACHE_DIR = str(Path(of_the_user or folder / "numba") / key)
    try:
        yield
    finally:
        settings.CACHE_DIR = of_the_user


class CacheFiles:
    """
    Files in which numba keeps functions: those of a folder (None: nowhere) whose names have a pattern.

    numba loads what is in them without a look. So the digest of each is written next to it when it is made,
    and a file without the right one is removed before it is loaded; numba compiles again then.
    """

    def __init__(self, folder: Path | None, pattern: str) -> None:
        self.folder = folder
        self.pattern = pattern

    def drop_damaged(self) -> None:
        """Remove files whose digest is missing or another one."""
        for file in self._files():
            try:
                if file.with_name(file.name + _CHECKED).read_text(encoding="ascii") == _digest(file):
                    continue
            except (OSError, UnicodeDecodeError):
                pass
            _remove(file)

    def note_digests(self) -> None:
        """Write the digest of each file next to it."""
        for file in self._files():
            try:
                file.with_name(file.name + _CHECKED).write_text(_digest(file), encoding="ascii")
            except OSError:
                continue  # without it the file is removed before it is loaded

    def _files(self) -> list[Path]:
        if self.folder is None:
            return []
        return [f for kind in ("nbi", "nbc") for f in self.folder.glob(f"{self.pattern}.{kind}")]


def _digest(file: Path) -> str:
    return hashlib.sha256(file.read_bytes()).hexdigest()


def _remove(file: Path) -> None:
    try:
        file.unlink()
    except OSError:
        return

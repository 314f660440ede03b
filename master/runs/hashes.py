"""Hashes of what a run reads and writes."""

from __future__ import annotations

import hashlib
from pathlib import Path

_BLOCK = 2**20


def sha256(path: Path) -> str:
    """
    Hash a file, or a folder that an FMU was unpacked into: its files with their names, in order.

    Raises:
        OSError: If it cannot be read.
    """
    if not path.is_dir():
        return _of_file(path)
    whole = hashlib.sha256()
    for file in sorted(p for p in path.rglob("*") if p.is_file()):
        whole.update(f"{file.relative_to(path).as_posix()}\0{_of_file(file)}\n".encode())
    return whole.hexdigest()


def _of_file(path: Path) -> str:
    found = hashlib.sha256()
    with path.open("rb") as file:
        while block := file.read(_BLOCK):
            found.update(block)
    return found.hexdigest()

"""A temporary folder for one command; it goes with all that compilers and processes left in it."""

from __future__ import annotations

import contextlib
import os
import secrets
import shutil
import tempfile
from pathlib import Path

_VARIABLE = "TMPDIR"  # what Python and compilers look at

_folder: Path | None = None


def make() -> None:
    """Let all temporary files of this process, and of those it starts, be in a folder of their own."""
    global _folder
    with contextlib.suppress(OSError):  # no place for it: what needs one will say so
        _folder = Path(tempfile.gettempdir()) / f"dockloop-{secrets.token_hex(6)}"
        _folder.mkdir(mode=0o700)
        tempfile.tempdir = os.environ[_VARIABLE] = str(_folder)


def remove() -> None:
    """Remove the folder, whatever moment `make` came to."""
    if _folder is not None:
        shutil.rmtree(_folder, ignore_errors=True)

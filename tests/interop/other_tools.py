"""Other tools: found, or the test is skipped with what to install."""

from __future__ import annotations

import os
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest


def require(found: object, install: str) -> None:
    """Skip the test if a tool is absent; fail where all tools are promised."""
    if found:
        return
    message = f"a tool is absent, expected: {install}"
    if os.environ.get("CI"):
        pytest.fail(message)
    pytest.skip(message)


def importable(name: str) -> bool:
    done = subprocess.run([sys.executable, "-c", f"import {name}"], capture_output=True, check=False)
    return done.returncode == 0


def unpack_library(fmu: Path, folder_name: str, to: Path) -> Path:
    """Unpack the library of one platform."""
    with zipfile.ZipFile(fmu) as archive:
        (name,) = (n for n in archive.namelist() if n.startswith(f"binaries/{folder_name}/"))
        return Path(archive.extract(name, to))

"""Names of this platform in an FMU; FMPy knows them too, but takes a quarter of a second to load."""

from __future__ import annotations

import platform
import sys

_SYSTEMS = {"win32": ("win", "windows", ".dll"), "darwin": ("darwin", "darwin", ".dylib")}
_SHORT, _LONG, LIBRARY_SUFFIX = _SYSTEMS.get(sys.platform, ("linux", "linux", ".so"))
_BITS = 64 if sys.maxsize > 2**32 else 32
_IS_ARM = platform.machine().lower() in ("aarch64", "arm64")
_ARCHITECTURE = "aarch64" if _IS_ARM else "x86_64" if _BITS == 64 else "x86"

FMI2_FOLDER = f"{_SHORT}{_BITS}"
"""Folder of binaries of FMI 2.0, as `linux64`."""

FMI3_FOLDER = f"{_ARCHITECTURE}-{_LONG}"
"""Folder of binaries of FMI 3.0, as `x86_64-linux`."""

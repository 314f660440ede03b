"""Folders of unpacked FMUs. Instances of one FMU share a folder, and with it the library in memory."""

from __future__ import annotations

import shutil
import tempfile
import zipfile
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path, PurePosixPath

from master.errors import FmuError

from .description import Description

Unpack = Callable[[Path], str]
_Key = tuple[Path, int, int]


@dataclass
class _Folder:
    path: str
    users: int = 0


_shared: dict[_Key, _Folder] = {}
_place: Path | None = None


def place_in(folder: Path) -> None:
    """Unpack FMUs below a folder from now on, instead of the system's temporary one."""
    global _place
    _place = folder


def new_folder() -> str:
    """Make a folder for an unpacked FMU."""
    return tempfile.mkdtemp(prefix="dockloop-", dir=_place)


def acquire(description: Description, unpack: Unpack) -> str:
    """
    Give an FMU's folder: one for all of its instances, or one each where it says that it needs that.

    A library that lies in many folders is many libraries to the system, and their code displaces each
    other from the processor's cache: a hundred small FMUs step at two thirds of the speed.
    """
    if not description.can_share_library:
        return unpack(description.path)
    key = _key(description.path)
    if key not in _shared:
        _shared[key] = _Folder(unpack(description.path))
    _shared[key].users += 1
    return _shared[key].path


def require_binary(name: str, description: Description) -> None:
    """Raise FmuError if an FMU has no library for this platform."""
    from fmpy import platform, platform_tuple

    wanted = platform if description.version == 2 else platform_tuple
    with zipfile.ZipFile(description.path) as archive:
        parts = [PurePosixPath(member).parts for member in archive.namelist()]
    there = sorted({p[1] for p in parts if len(p) == 3 and p[0] == "binaries"})
    if wanted not in there:
        listed = ", ".join(there) or "none"
        raise FmuError(name, f"no binary for this platform, got {listed}, expected {wanted}")


def release(path: str) -> None:
    """Remove a folder that nobody needs any more."""
    for key, folder in list(_shared.items()):
        if folder.path == path:
            folder.users -= 1
            if folder.users:
                return
            del _shared[key]
    shutil.rmtree(path, ignore_errors=True)


def _key(path: Path) -> _Key:
    stat = path.stat()
    return path.resolve(), stat.st_mtime_ns, stat.st_size

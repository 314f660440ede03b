"""
Folders of unpacked FMUs, and what must be in them.

Instances of one FMU share a folder, and with it the library in memory.
"""

from __future__ import annotations

import platform
import shutil
import sys
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from master.errors import ConfigError
from master.text.archive import Archive, ArchiveError

from .description import Description
from .description_reader import DESCRIPTION
from .platforms import FMI2_FOLDER, FMI3_FOLDER, LIBRARY_SUFFIX

Unpack = Callable[[Description], str]
_Key = tuple[Path, int, int]


@dataclass
class _Folder:
    path: str
    users: int = 0


_shared: dict[_Key, _Folder] = {}
_is_kept = False


@contextmanager
def kept() -> Iterator[None]:
    """
    Unpack each FMU once until this ends, although it is not loaded all the time.

    For many runs of FMUs that are known to leave what they were unpacked with as it is.
    """
    global _is_kept
    before = _is_kept
    _is_kept = True
    try:
        yield
    finally:
        _is_kept = before
        if not _is_kept:
            for key in [key for key, folder in _shared.items() if not folder.users]:
                shutil.rmtree(_shared.pop(key).path, ignore_errors=True)


def acquire(description: Description, unpack: Unpack) -> str:
    """
    Return an FMU's folder: one for all of its instances, or one each where it says that it needs that.

    A library that lies in many folders is many libraries to the system, and their code displaces each
    other from the processor's cache: a hundred small FMUs step at two thirds of the speed.

    Raises:
        ConfigError: If the FMU cannot be unpacked, or has no library that this platform can load.
    """
    if not description.can_share_library:
        return unpack(description)
    key = _key(description.path)
    if key not in _shared:
        _shared[key] = _Folder(unpack(description))
    _shared[key].users += 1
    return _shared[key].path


def release(path: str) -> None:
    """Remove a folder that nobody needs any more."""
    for key, folder in list(_shared.items()):
        if folder.path == path:
            folder.users -= 1
            if folder.users or _is_kept:
                return
            del _shared[key]
    shutil.rmtree(path, ignore_errors=True)


def unpack(description: Description) -> str:
    """
    Unpack what an FMU needs to run here into a new folder: its resources and this platform's binary.

    Raises:
        ConfigError: If that cannot be done; no folder is left.
    """
    try:
        with Archive(description.path) as archive:
            _require_binary(description, archive)
            folder = archive.unpacked(_is_needed)
    except (ArchiveError, OSError) as error:
        raise ConfigError([f"{description.path}: cannot be unpacked: {error}"]) from None
    (folder / "resources").mkdir(exist_ok=True)  # named to the FMU, also where it is empty
    return str(folder)


def require_runnable(descriptions: Iterable[Description]) -> None:
    """
    Check, without loading them, that FMUs have what they need to run here and that they can be unpacked.

    Raises:
        ConfigError: With the fault of each that has not.
    """
    problems: list[str] = []
    for description in {d.path: d for d in descriptions}.values():
        try:
            _read_what_is_needed(description)
        except ConfigError as error:
            problems += error.problems
    if problems:
        raise ConfigError(problems)


def _read_what_is_needed(description: Description) -> None:
    try:
        with Archive(description.path) as archive:
            _require_binary(description, archive)
            for name in filter(_is_needed, archive.names):
                archive.verify(name)
    except (ArchiveError, OSError) as error:
        raise ConfigError([f"{description.path}: cannot be unpacked: {error}"]) from None


def _is_needed(name: str) -> bool:
    folders = ("resources/", f"binaries/{FMI2_FOLDER}/", f"binaries/{FMI3_FOLDER}/")
    return name == DESCRIPTION or name.startswith(folders)


def _require_binary(description: Description, archive: Archive) -> None:
    """Refuse an FMU whose library is missing, has another name, or is none of this platform."""
    wanted = FMI2_FOLDER if description.version == 2 else FMI3_FOLDER
    parts = [name.split("/") for name in archive.names if name.startswith("binaries/")]
    there = sorted({p[1] for p in parts if len(p) >= 3})
    if wanted not in there:
        listed = ", ".join(there) or "none"
        raise ConfigError(
            [f"{description.path}: no binary for this platform, got {listed}, expected {wanted}"]
        )
    library = f"{description.model_identifier}{LIBRARY_SUFFIX}"
    if f"binaries/{wanted}/{library}" not in archive.names:
        listed = ", ".join(p[2] for p in parts if len(p) == 3 and p[1] == wanted)
        problem = f"no binary of the name in its description, got {listed}, expected {library}"
        raise ConfigError([f"{description.path}: {problem}"])
    fault = _library_fault(archive.read(f"binaries/{wanted}/{library}")[:20])
    if fault is not None:
        raise ConfigError([f"{description.path}: binaries/{wanted}/{library}: {fault}"])


_ELF_MACHINES = {"x86_64": 62, "aarch64": 183, "i686": 3, "riscv64": 243, "ppc64le": 21}
_ELF_SHARED = 3


def _library_fault(head: bytes) -> str | None:
    """Say what is wrong with a shared library, by the first bytes of its file; on Linux alone."""
    if not sys.platform.startswith("linux"):
        return None
    if head[:4] != b"\x7fELF" or len(head) < 20:
        return "not a library, expected a shared object of Linux (ELF)"
    order: Literal["little", "big"] = "little" if head[5] == 1 else "big"
    kind, machine = (int.from_bytes(head[i : i + 2], order) for i in (16, 18))
    if kind != _ELF_SHARED:
        return f"not a shared library, got an ELF file of type {kind}, expected {_ELF_SHARED}"
    names = {number: name for name, number in _ELF_MACHINES.items()}
    here = _ELF_MACHINES.get(platform.machine())
    if here is not None and machine != here:
        got = names.get(machine, f"machine number {machine}")
        return f"a library of another machine, got {got}, expected {platform.machine()}"
    return None


def _key(path: Path) -> _Key:
    stat = path.stat()
    return path.resolve(), stat.st_mtime_ns, stat.st_size

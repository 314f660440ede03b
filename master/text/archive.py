"""
Zip archives (FMU, SSP) and unpacked folders in their place: safe names, readable members, clear refusals.

A member's name has forward slashes here, whatever the archive was written with.
"""

from __future__ import annotations

import errno
import lzma
import shutil
import stat
import struct
import tempfile
import zipfile
import zlib
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from types import TracebackType

_METHODS = {
    1: "Shrink",
    6: "Implode",
    9: "Deflate64",
    20: "Zstandard",
    93: "Zstandard",
    94: "MP3",
    95: "xz",
    96: "JPEG",
    97: "WavPack",
    98: "PPMd",
    99: "AES encryption",
}
_READABLE = (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED, zipfile.ZIP_BZIP2, zipfile.ZIP_LZMA)
_ENCRYPTED = 0x1  # flag of a member

_PIECE = 2**20
MOST_MEMBERS = 100_000
MOST_READ = 2**28  # bytes of a member that is read whole
MOST_UNPACKED = 2**31  # bytes of all members together
_MOST_SAID = 200  # characters
_UNIX = 3  # system that wrote a member: its mode is in the upper half of external_attr


_DAMAGES = (  # what Python raises for a damaged archive
    zipfile.BadZipFile,
    zlib.error,
    lzma.LZMAError,
    struct.error,
    EOFError,
    OverflowError,
    ValueError,
    OSError,
    NotImplementedError,
)


class ArchiveError(Exception):
    """An archive or one of its members cannot be read; the text says what, got, and expected."""


class NotAnArchiveError(ArchiveError):
    """A file is no zip archive at all."""


class Archive:
    """
    A zip archive, or a folder with the same content, open for reading.

    Raises:
        FileNotFoundError: If there is no such file or folder.
        ArchiveError: If it is no archive, or a member's name leads out of it.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self._zip: zipfile.ZipFile | None = None
        self._members: dict[str, zipfile.ZipInfo | Path] = {}
        self._ambiguous: set[str] = set()  # there twice, with different contents
        if path.is_dir():
            self._list_folder()
        else:
            self._list_zip()

    def __enter__(self) -> Archive:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if self._zip is not None:
            self._zip.close()

    @property
    def names(self) -> list[str]:
        """Names of all files, without folders."""
        return list(self._members)

    def read(self, name: str) -> bytes:
        """
        Read a member whole.

        Raises:
            KeyError: If there is none of this name.
            ArchiveError: If it is encrypted, damaged, packed by a method that cannot be read, or there twice
                with different contents.
        """
        member = self._members[name]
        if name in self._ambiguous:
            raise ArchiveError(f"{name}: twice in the archive with different contents, expected one")
        try:
            if isinstance(member, Path):
                return member.read_bytes()
            assert self._zip is not None
            self._require_readable(name, member)
            if member.file_size > MOST_READ:
                raise ArchiveError(
                    f"{name}: too large, got {_megabytes(member.file_size)} MB, expected at most "
                    f"{_megabytes(MOST_READ)} MB"
                )
            return self._zip.read(member)
        except _DAMAGES as error:
            raise _damaged(name, error) from None

    def extract(self, wanted: Callable[[str], bool], folder: Path) -> None:
        """Write the members whose names are wanted below a folder; ArchiveError as in `read`."""
        for name in filter(wanted, self.names):
            target = folder / name
            target.parent.mkdir(parents=True, exist_ok=True)
            self._write(name, target)

    def verify(self, name: str) -> None:
        """Read a member to its end and keep nothing of it; KeyError and ArchiveError as in `read`."""
        for _ in self._pieces(name):
            pass

    def _write(self, name: str, target: Path) -> None:
        with target.open("wb") as file:
            for piece in self._pieces(name):
                file.write(piece)

    def _pieces(self, name: str) -> Iterator[bytes]:
        """Read a member piece by piece; a large one needs no more memory than a small one."""
        member = self._members[name]
        if isinstance(member, Path) or member.file_size <= _PIECE or name in self._ambiguous:
            yield self.read(name)
            return
        assert self._zip is not None
        self._require_readable(name, member)
        try:
            with self._zip.open(member) as source:
                while piece := source.read(_PIECE):
                    yield piece
        except _DAMAGES as error:
            raise _damaged(name, error) from None

    def unpacked(self, wanted: Callable[[str], bool], prefix: str = "dockloop-") -> Path:
        """Unpack into a new temporary folder, of which nothing stays if it fails."""
        folder = Path(tempfile.mkdtemp(prefix=prefix))
        try:
            self.extract(wanted, folder)
        except BaseException:
            shutil.rmtree(folder, ignore_errors=True)
            raise
        return folder

    def _list_folder(self) -> None:
        for file in sorted(self.path.rglob("*")):
            name = file.relative_to(self.path).as_posix()
            if not file.resolve().is_relative_to(self.path.resolve()):
                raise ArchiveError(f"{name}: leads out of the folder, got a link to {file.resolve()}")
            if file.is_file():
                self._members[name] = file

    def _list_zip(self) -> None:
        try:
            self._zip = zipfile.ZipFile(self.path)
        except zipfile.BadZipFile:
            raise NotAnArchiveError("not a zip archive") from None
        except _DAMAGES as error:
            if isinstance(error, OSError) and error.errno != errno.EINVAL:  # EINVAL: a place before the file
                raise
            raise ArchiveError(
                f"its directory is damaged, got {_said(error)}, expected a zip archive"
            ) from None
        faults = []
        for info in self._zip.infolist():
            name = info.filename.replace("\\", "/")
            fault = _name_fault(name) or _link_fault(info)
            if fault is not None:
                faults.append(f"member {info.filename!r}: {fault}, expected a name inside the archive")
            elif not name.endswith("/"):
                plain = "/".join(_parts(name))  # some tools write `./` before each name
                other = self._members.setdefault(plain, info)
                if isinstance(other, zipfile.ZipInfo) and other.CRC != info.CRC:
                    self._ambiguous.add(plain)
        faults += [f"member {n!r}: a file and a folder" for n in _files_as_folders(self._members)]
        faults += self._size_faults()
        faults += _alike(self._members)
        if faults:
            self._zip.close()
            raise ArchiveError("; ".join(faults))

    def _size_faults(self) -> list[str]:
        """Say that the archive has more members or bytes than any FMU needs, by what its directory says."""
        assert self._zip is not None
        infos = self._zip.infolist()
        n_bytes = sum(info.file_size for info in infos)
        faults = []
        if len(infos) > MOST_MEMBERS:
            faults.append(f"too many members, got {len(infos)}, expected at most {MOST_MEMBERS}")
        if n_bytes > MOST_UNPACKED:
            got = f"got {_megabytes(n_bytes)} MB unpacked"
            faults.append(f"too large, {got}, expected at most {_megabytes(MOST_UNPACKED)} MB")
        return faults

    @staticmethod
    def _require_readable(name: str, info: zipfile.ZipInfo) -> None:
        if info.flag_bits & _ENCRYPTED:
            raise ArchiveError(f"{name}: encrypted, expected a member that is readable without a password")
        if info.compress_type not in _READABLE:
            method = _METHODS.get(info.compress_type, "an unknown method")
            raise ArchiveError(
                f"{name}: packed by a method that cannot be read, got {method} ({info.compress_type}), "
                "expected Deflate or none"
            )


def _parts(name: str) -> list[str]:
    return [part for part in name.split("/") if part not in ("", ".")]


def _name_fault(name: str) -> str | None:
    """Say what is wrong with a member's name (with forward slashes)."""
    parts = _parts(name)
    if name.startswith("/") or ":" in name.partition("/")[0]:
        return "an absolute name"
    if ".." in parts:
        return "leads out of the archive"
    if not parts or "\0" in name:
        return "not a name"
    return None


def _link_fault(info: zipfile.ZipInfo) -> str | None:
    is_link = info.create_system == _UNIX and stat.S_ISLNK(info.external_attr >> 16)
    return "a link" if is_link else None


def _files_as_folders(names: Iterable[str]) -> list[str]:
    """Files that are folders of other files."""
    folders: set[str] = set()
    for name in names:
        folder = name.rpartition("/")[0]
        while folder and folder not in folders:
            folders.add(folder)
            folder = folder.rpartition("/")[0]
    return sorted(folders & set(names))


def _damaged(name: str, error: Exception) -> ArchiveError:
    got = _said(error) or "an early end"
    return ArchiveError(f"{name}: damaged, got {got}, expected a readable member")


def _said(error: Exception) -> str:
    """What Python says, which may hold all that it has read."""
    return str(error)[:_MOST_SAID]


def _alike(names: Iterable[str]) -> list[str]:
    """Say which names differ only in upper and lower case: on some systems they are one file."""
    first: dict[str, str] = {}
    alike = [(first[n.casefold()], n) for n in names if first.setdefault(n.casefold(), n) != n]
    return [f"members {a!r} and {b!r}: names that differ only in upper and lower case" for a, b in alike[:10]]


def _megabytes(n_bytes: int) -> int:
    return -(-n_bytes // 2**20)

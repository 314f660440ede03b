"""Where the files of a system are: an SSP archive, a folder with an SSD, an archive within another."""

from __future__ import annotations

import io
import re
import stat
import zipfile
import zlib
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import IO, Protocol
from urllib.parse import SplitResult, unquote, urlsplit

from master.errors import ConfigError

MOST_BYTES = 4 * 2**30  # of all files of an archive, unpacked
MOST_RATIO = 200  # unpacked over packed size of a large file; deflate reaches 1000 on zeros alone
LARGE = 16 * 2**20  # bytes from which on the ratio is looked at

_METHOD_NAMES = {9: "deflate64", 12: "bzip2", 14: "lzma", 93: "zstd"}
_METHODS = (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED)
_CORRUPT = (zipfile.BadZipFile, zlib.error, EOFError, NotImplementedError, RuntimeError, ValueError, OSError)


class Package(Protocol):
    """Files by their paths with slashes; `label` is what messages call it."""

    label: str

    def name_of(self, member: str) -> str:
        """What messages call a file."""

    def has(self, member: str) -> bool:
        """Whether there is such a file."""

    def read(self, member: str) -> bytes:
        """Content of a file; ConfigError if it cannot be read."""

    def unpacked(self, member: str, folder: Path, suffix: str | None = None) -> Path:
        """Path of a file on disk, in the folder if it has to be unpacked; `suffix` in place of its own."""


@dataclass(frozen=True)
class Location:
    """A file of a package, and the fragment of the URI that named it."""

    member: str
    fragment: str


class Archive:
    """
    A zip archive that is safe to read.

    Raises:
        ConfigError: If it is corrupt, encrypted, packed by another method than the standard allows, larger
            than `MOST_BYTES`, or holds links or paths that lead outside.
    """

    def __init__(self, content: Path | bytes, label: str) -> None:
        self.label = label
        self._unpacked: dict[str, Path] = {}
        source: Path | IO[bytes] = content if isinstance(content, Path) else io.BytesIO(content)
        try:
            self._zip = zipfile.ZipFile(source)
        except FileNotFoundError:
            raise ConfigError([f"{label}: no such file, expected an SSP archive"]) from None
        except _CORRUPT as error:
            raise ConfigError(
                [f"{label}: not an SSP archive ({_said(error)}), expected a zip file"]
            ) from None
        self._entries = self._checked()

    def _checked(self) -> dict[str, zipfile.ZipInfo]:
        problems: list[str] = []
        entries: dict[str, zipfile.ZipInfo] = {}
        for info in self._zip.infolist():
            name = info.filename.replace("\\", "/").removeprefix("./")
            problems += [f"{self.label}: {name!r}: {fault}" for fault in _entry_faults(info, name)]
            if name in entries:
                problems.append(f"{self.label}: {name!r}: twice in the archive, expected one file of a name")
            if not name.endswith("/"):
                entries[name] = info
        total = sum(info.file_size for info in self._zip.infolist())
        if total > MOST_BYTES:
            problems.append(
                f"{self.label}: too large, got {total} bytes unpacked, expected at most {MOST_BYTES}"
            )
        if problems:
            raise ConfigError(problems)
        return entries

    def close(self) -> None:
        """Close the file."""
        self._zip.close()

    @property
    def names(self) -> list[str]:
        """Names of the files."""
        return list(self._entries)

    def name_of(self, member: str) -> str:
        return f"{self.label}: {member}"

    def has(self, member: str) -> bool:
        return member in self._entries

    def read(self, member: str) -> bytes:
        with self._reading(member):
            return self._zip.read(self._entries[member])

    def unpacked(self, member: str, folder: Path, suffix: str | None = None) -> Path:
        if member not in self._unpacked:
            name = Path(member.rpartition("/")[2])
            stem = re.sub(r"[^A-Za-z0-9_-]", "_", name.stem)[:100]
            ending = re.sub(r"[^.A-Za-z0-9]", "_", name.suffix)[:20] if suffix is None else suffix
            n = len(list(folder.iterdir()))
            path = folder / str(n) / f"{stem}{ending}"
            content = self.read(member)
            path.parent.mkdir()
            path.write_bytes(content)
            self._unpacked[member] = path
        return self._unpacked[member]

    @contextmanager
    def _reading(self, member: str) -> Iterator[None]:
        try:
            yield
        except KeyError:
            raise ConfigError([f"{self.label}: no file {member!r} in the archive"]) from None
        except _CORRUPT as error:
            raise ConfigError([f"{self.label}: {member!r}: corrupt, got {_said(error)}"]) from None


def _said(error: Exception) -> str:
    return str(error).splitlines()[0] if str(error) else type(error).__name__


def _entry_faults(info: zipfile.ZipInfo, name: str) -> list[str]:
    faults = []
    if info.flag_bits & 0x1:
        faults.append("encrypted, expected a file without password")
    if info.compress_type not in _METHODS:
        method = _METHOD_NAMES.get(info.compress_type, "an unknown one")
        got = f"got {method} ({info.compress_type})"
        faults.append(f"packed by a method that SSP does not allow, {got}, expected stored or deflate")
    if stat.S_ISLNK(info.external_attr >> 16):
        faults.append("a link, expected files alone")
    if name.startswith("/") or ".." in name.split("/") or re.match(r"[A-Za-z]:", name):
        faults.append("leads outside the archive, expected a relative path")
    if info.file_size > LARGE and info.file_size > MOST_RATIO * max(info.compress_size, 1):
        ratio = info.file_size / max(info.compress_size, 1)
        faults.append(f"grows {ratio:.0f} times when unpacked, expected at most {MOST_RATIO} times")
    return faults


class Folder:
    """The folder of an SSD that is not packed."""

    def __init__(self, folder: Path, label: str) -> None:
        self.folder = folder
        self.label = label

    def name_of(self, member: str) -> str:
        return str(self.folder / member)

    def has(self, member: str) -> bool:
        path = (self.folder / member).resolve()
        try:
            return path.is_relative_to(self.folder.resolve()) and path.is_file()
        except OSError:
            return False

    def read(self, member: str) -> bytes:
        try:
            return (self.folder / member).read_bytes()
        except OSError as error:
            fault = f"{self.label}: {member!r}: cannot be read, got {error.strerror}"
            raise ConfigError([fault]) from None

    def unpacked(self, member: str, folder: Path, suffix: str | None = None) -> Path:
        return (self.folder / member).absolute()


def locate(package: Package, base: str, source: str) -> Location:
    """
    Find the file that a URI names.

    Args:
        package: Where to look.
        base: Folder within it that relative paths start from, empty or with a slash at the end.
        source: The URI; backslashes are taken for slashes, a name that is not encoded as it is.

    Raises:
        ValueError: If it leads outside or to no file.
    """
    text = source.strip().replace("\\", "/")
    try:
        parts = urlsplit(text)
        decoded: str | None = _inside(base, unquote(_path_of(parts)))
        fault = None
    except ValueError as error:
        parts = SplitResult("", "", "", "", "")
        decoded = None
        fault = str(error)
    if decoded is not None and package.has(decoded):
        return Location(decoded, unquote(parts.fragment))
    try:
        literal = _inside(base, text)
    except ValueError:
        literal = ""
    if literal and package.has(literal):
        return Location(literal, "")
    raise ValueError(fault or f"no such file, got {source!r}, expected one in {package.label}")


def _path_of(parts: SplitResult) -> str:
    if parts.scheme not in ("", "file") or parts.netloc:
        raise ValueError(f"outside the archive, got {parts.geturl()!r}, expected a relative path")
    if parts.query:
        raise ValueError(f"not a path, got a query {parts.query!r}, expected a relative path")
    return parts.path


def _inside(base: str, path: str) -> str:
    if path.startswith("/") or re.match(r"[A-Za-z]:", path):
        raise ValueError(f"outside the archive, got {path!r}, expected a relative path")
    kept: list[str] = []
    for part in (base + path).split("/"):
        if part == "..":
            if not kept:
                raise ValueError(f"outside the archive, got {path!r}, expected a relative path")
            kept.pop()
        elif part not in ("", "."):
            kept.append(part)
    return "/".join(kept)

"""
FMUs from sources: what is missing or stale is built, the rest is left as it is.

    fmus/<model>.fmu          native, FMI 2.0, all platforms: the release, committed and shipped
    fmus/fmi3/<model>.fmu     native, FMI 3.0, likewise
    <cache>/fmus/<flavour>/<token>/<model>.fmu
                              Python flavour, and native for this machine alone where the release is older
                              than the sources

A folder of the cache is named by the token of the FMU in it, so that several states of the sources share
the cache and no file is replaced while another process loads it.

What generates FMUs is loaded where it is used: most often all of them are there, and current.
"""

from __future__ import annotations

import xml.etree.ElementTree as ET
import zipfile
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING

from ..composed.registry import is_own, load, modules
from ..framework.model import Model
from .manifest import read_manifest
from .places import FMU_FOLDER, cache_folder
from .stamp_cache import StampCache
from .whole_file import write_whole

if TYPE_CHECKING:
    from .native_flavour import NativeSources

FLAVOURS = ("native", "python", "fmi3")
_VERSION = {"native": "2.0", "fmi3": "3.0"}


@dataclass(frozen=True)
class Target:
    """One FMU to be: the model, its flavour, where the file stands, and the GUID that it must have."""

    model: str
    flavour: str
    path: Path
    token: str

    def is_current(self) -> bool:
        """Whether the file is there and was built from the present sources."""
        return self.path.is_file() and token_of(self.path) == self.token


def token_of(path: Path) -> str:
    """Read the GUID of an FMU; empty if the file is not one."""
    try:
        with zipfile.ZipFile(path) as archive:
            root = ET.fromstring(archive.read("modelDescription.xml"))
    except (zipfile.BadZipFile, KeyError, ET.ParseError):
        return ""
    return root.get("guid") or root.get("instantiationToken") or ""


def release_path(name: str, flavour: str, folder: Path = FMU_FOLDER) -> Path:
    """Place of a native FMU of the release."""
    return folder / f"{name}.fmu" if flavour == "native" else folder / "fmi3" / f"{name}.fmu"


def cached_path(name: str, flavour: str, token: str) -> Path:
    """Place of an FMU that is built here."""
    return cache_folder() / "fmus" / flavour / token.strip("{}") / f"{name}.fmu"


def target(name: str, flavour: str = "native", folder: Path = FMU_FOLDER) -> Target:
    """Name the FMU of a model, released into `folder` or kept in the cache; KeyError if there is none."""
    if is_own(name):
        token = _own_sources(load(name), modules(name)[0]).token
        return Target(name, flavour, cached_path(name, flavour, token), token)
    if flavour == "python":
        token = _python_token(name)
        return Target(name, flavour, cached_path(name, flavour, token), token)
    stamp = _stamps().stamp(name, lambda: _native_stamp(name))
    entry = read_manifest(folder).get(name)
    if entry is not None and entry.sources == stamp:
        released = Target(name, flavour, release_path(name, flavour, folder), entry.token)
        if released.is_current():
            return released
    return Target(name, flavour, cached_path(name, flavour, stamp), stamp)


def own_target(file: Path, flavour: str = "native") -> Target:
    """
    Name the FMU of a model that is not of this package, kept in the cache.

    Raises:
        OwnModelError: If the model is wrong, or for the Python flavour, which carries this package alone.
    """
    from .own_model import VERSIONS, OwnModelError, added

    if flavour not in VERSIONS:
        raise OwnModelError(
            f"{file}: flavour of a model by path, got {flavour!r}, expected one of {[*VERSIONS]}"
        )
    return target(added(file), flavour)


@cache
def _own_sources(model: Model, file: Path) -> NativeSources:
    from .own_model import own_sources

    return own_sources(model, file)


def _python_token(name: str) -> str:
    from .python_flavour import python_sources, python_token

    return python_token(load(name), python_sources(*modules(name)))


@cache
def _stamps() -> StampCache:
    return StampCache()


def _native_stamp(name: str) -> str:
    from .native_flavour import source_stamp

    return source_stamp(load(name), *modules(name))


def build(wanted: Target) -> Path:
    """Build the FMU for this machine and put it in its place in one move."""
    from .native_flavour import host_binaries, native_sources, pack_native
    from .python_flavour import build_python

    model, files = load(wanted.model), modules(wanted.model)
    if wanted.flavour == "python":
        content = build_python(model, *files)
    else:
        sources = _own_sources(model, files[0]) if is_own(wanted.model) else native_sources(model, *files)
        content = pack_native(sources, host_binaries(sources), _VERSION[wanted.flavour])
    write_whole(wanted.path, content)
    return wanted.path


def build_with_starts(name: str, starts: Mapping[str, float], flavour: str, path: Path) -> Path:
    """
    Build an FMU of a model with other start values, for every platform that can be compiled for here.

    Args:
        name: The model.
        starts: Start values by the names of its variables.
        flavour: One of `FLAVOURS`.
        path: The file to write.

    Raises:
        NativeBuildError: If no compiler is here.
    """
    from ..framework.starts import with_starts
    from .native import MissingToolError
    from .native_flavour import host_binaries, native_sources, pack_native, release_binaries
    from .python_flavour import build_python

    files = modules(name)
    if flavour == "python":
        content = build_python(load(name), *files, starts=starts)
    else:
        model = with_starts(load(name), starts)
        sources = _own_sources(model, files[0]) if is_own(name) else native_sources(model, *files)
        try:
            binaries = release_binaries(sources)
        except MissingToolError:
            binaries = host_binaries(sources)
        content = pack_native(sources, binaries, _VERSION[flavour])
    path.parent.mkdir(parents=True, exist_ok=True)
    write_whole(path, content)
    return path

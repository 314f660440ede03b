"""The native flavour: a model as an FMU of FMI 2.0 or 3.0 that needs nothing in the host."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path

from ..composed.registry import ROOT, source_files
from ..framework.model import Model
from . import native
from .archive import pack
from .documentation import documentation_files
from .facts import Flavour, guid
from .fmi2_xml import describe_fmi2
from .fmi3_xml import describe_fmi3
from .reference_data import reference_files, reference_paths
from .terminals import terminal_files

NATIVE = Flavour("native flavour", needs_execution_tool=False, directional_derivatives=True)

_EXPORT = Path(__file__).parent


@dataclass(frozen=True)
class NativeSources:
    """All that a native FMU is made of, before compilation: the same for both FMI versions."""

    model: Model
    token: str
    files: Mapping[str, bytes] = field(repr=False)
    reference: Mapping[str, bytes] = field(repr=False, default_factory=dict)


@cache
def source_stamp(model: Model, model_file: Path, *more: Path) -> str:
    """Digest of all sources that the FMU is generated from, in the form of a GUID; generates nothing."""
    generator = [
        p for p in _EXPORT.rglob("*") if p.suffix in (".py", ".c", ".h") and p.name not in _NOT_NATIVE
    ]
    used = sorted({*source_files(model_file, *more), *generator, *reference_paths(model, model_file)})
    contents = [part for p in used for part in (p.relative_to(ROOT).as_posix().encode(), p.read_bytes())]
    return guid(describe_fmi2(model, NATIVE, ""), *contents)


_NOT_NATIVE = {
    "python_flavour.py",
    "python_slave.py",
    "build.py",
    "own_model.py",
    "release.py",
    "manifest.py",
    "places.py",
    "errors.py",
    "stamp_cache.py",
    "whole_file.py",
}


def native_sources(model: Model, model_file: Path, *more: Path, token: str | None = None) -> NativeSources:
    """Generate the C files of a model; `more` are the files that compose it; GUID by default the stamp."""
    token = source_stamp(model, model_file, *more) if token is None else token
    return NativeSources(model, token, native.generate(model, token), reference_files(model, model_file))


def content_digest(model: Model, model_file: Path) -> str:
    """Digest of all that both FMUs of a model hold before compilation, whatever their GUID."""
    return content_digest_of(native_sources(model, model_file, token=""))


def content_digest_of(sources: NativeSources) -> str:
    """Digest of all that both FMUs hold before compilation."""
    digest = hashlib.sha256()
    for version in ("2.0", "3.0"):
        for name, content in sorted(_contents(sources, version).items()):
            digest.update(f"{name}\0{len(content)}\0".encode() + content)
    return digest.hexdigest()


def host_binaries(sources: NativeSources) -> dict[str, bytes]:
    """Compile for this machine alone: path in the FMU to library."""
    name = sources.model.name
    library = native.compile_host(sources.files, name)
    return {f"binaries/{folder}/{name}{ending}": library for folder, ending in native.host_folders()}


def release_binaries(sources: NativeSources) -> dict[str, bytes]:
    """Compile for every platform."""
    return native.compile_release(sources.files, sources.model.name)


def pack_native(sources: NativeSources, binaries: Mapping[str, bytes], fmi_version: str) -> bytes:
    """Put an FMU of one FMI version together."""
    return pack(_contents(sources, fmi_version) | native.of_version(binaries, fmi_version))


def _contents(sources: NativeSources, fmi_version: str) -> dict[str, bytes]:
    """All files of an FMU but its binaries."""
    model = sources.model
    contents = {f"sources/{name}": content for name, content in sources.files.items()}
    contents |= documentation_files(model) | dict(sources.reference)
    if fmi_version == "2.0":
        c_files = tuple(native.c_files(sources.files))
        contents["modelDescription.xml"] = describe_fmi2(model, NATIVE, sources.token, c_files)
    else:
        contents["modelDescription.xml"] = describe_fmi3(model, NATIVE, sources.token)
        contents["sources/buildDescription.xml"] = native.build_description(sources.files, model.name)
        contents |= terminal_files(model)
    return contents

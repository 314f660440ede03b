"""The release build: all subsystems native, for all platforms and both FMI versions, reproducible."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterator
from pathlib import Path

from ..composed.registry import load, model_files
from .build import FMU_FOLDER, release_path, write
from .native_flavour import native_sources, pack_native, release_binaries

ROOMS = ("spacecraft", "motion_simulator", "docking_contact", "force_sensor", "compensator", "real_docking")
_VERSIONS = {"native": "2.0", "fmi3": "3.0"}


def release_models() -> list[str]:
    """Models that the release holds."""
    return [name for name, path in model_files().items() if path.parent.name in ROOMS]


def release_files(folder: Path = FMU_FOLDER) -> Iterator[dict[Path, bytes]]:
    """Build the release model by model: path to content."""
    for name in release_models():
        sources = native_sources(load(name), model_files()[name])
        binaries = release_binaries(sources)
        yield {
            release_path(name, flavour, folder): pack_native(sources, binaries, version)
            for flavour, version in _VERSIONS.items()
        }


def manifest(files: dict[Path, bytes], folder: Path = FMU_FOLDER) -> bytes:
    """List the files of a release with their SHA-256."""
    sums = {p.relative_to(folder).as_posix(): hashlib.sha256(c).hexdigest() for p, c in sorted(files.items())}
    return json.dumps({"sha256": sums}, indent=2).encode() + b"\n"


def write_release(files: dict[Path, bytes], folder: Path = FMU_FOLDER) -> None:
    """Put a release in its place, with its manifest."""
    for path, content in files.items():
        write(path, content)
    write(folder / "MANIFEST.json", manifest(files, folder))


def differences(files: dict[Path, bytes]) -> list[Path]:
    """Paths whose committed bytes are not those of the build."""
    return [p for p, content in files.items() if not p.is_file() or p.read_bytes() != content]

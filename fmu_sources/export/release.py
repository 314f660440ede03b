"""The release build: all subsystems native, for all platforms and both FMI versions, reproducible."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from .. import bill_of_materials
from ..composed.registry import is_released, load, model_files
from ..framework.model import Model
from .build import release_path
from .manifest import NAME, Entry, manifest, read_manifest
from .native_flavour import content_digest, native_sources, pack_native, release_binaries, source_stamp
from .places import FMU_FOLDER
from .whole_file import write_whole

_VERSIONS = {"native": "2.0", "fmi3": "3.0"}


def release_models() -> list[str]:
    """Models that the release holds."""
    return [name for name in model_files() if is_released(name)]


def release_files(folder: Path = FMU_FOLDER) -> Iterator[tuple[dict[Path, bytes], dict[str, Entry]]]:
    """Build the release model by model: path to content, and the model's entry in the manifest."""
    recorded = read_manifest(folder)
    for name in release_models():
        model, file = load(name), model_files()[name]
        entry = _entry(model, file, recorded.get(name))
        sources = native_sources(model, file, token=entry.token)
        binaries = release_binaries(sources)
        files = {
            release_path(name, flavour, folder): pack_native(sources, binaries, version)
            for flavour, version in _VERSIONS.items()
        }
        yield files, {name: entry}


def _entry(model: Model, file: Path, recorded: Entry | None) -> Entry:
    """Keep the recorded GUID as long as the content stays."""
    stamp, content = source_stamp(model, file), content_digest(model, file)
    kept = recorded is not None and recorded.content == content
    return Entry(stamp, content, recorded.token if recorded is not None and kept else stamp)


def write_release(files: dict[Path, bytes], entries: dict[str, Entry], folder: Path = FMU_FOLDER) -> None:
    """Put a release in its place, with its manifest and its bill of materials."""
    for path, content in _with_lists(files, entries, folder).items():
        write_whole(path, content)


def differences(files: dict[Path, bytes], entries: dict[str, Entry], folder: Path = FMU_FOLDER) -> list[Path]:
    """Paths whose committed bytes are not those of the build."""
    built = _with_lists(files, entries, folder)
    return [p for p, content in built.items() if not p.is_file() or p.read_bytes() != content]


def _with_lists(files: dict[Path, bytes], entries: dict[str, Entry], folder: Path) -> dict[Path, bytes]:
    fmus = {path.relative_to(folder).as_posix(): content for path, content in files.items()}
    return {
        **files,
        folder / NAME: manifest(files, entries, folder),
        folder / bill_of_materials.NAME: bill_of_materials.bill_of_materials(fmus),
    }

"""From a `source` to an FMU file: a path as it is, or a model of `fmu_sources`, built when stale."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path

from fmu_sources.export import build

from .errors import ConfigError, expected, shown

Progress = Callable[[str], None]
FLAVOURS = build.FLAVOURS


def silent(text: str) -> None:
    """Show nothing."""


def is_path(source: str) -> bool:
    """Whether a source names a file rather than a model."""
    return source.lower().endswith(".fmu") or "/" in source or "\\" in source


def locate(source: str, folder: Path, flavour: str) -> Path | build.Target:
    """
    Find the FMU of a source; for a model its build target.

    Raises:
        ConfigError: If it is neither a file nor a model.
    """
    if is_path(source):
        path = folder / source
        if not _is_fmu(path):
            raise ConfigError([f"no such file, got {shown(source)}, expected an FMU at {shown(path)}"])
        return path
    try:
        return build.target(source, flavour)
    except KeyError:
        from fmu_sources.composed import registry

        models = expected(source, registry.model_files())
        raise ConfigError([f"no such model, got {shown(source)}, {models}, or a path to an FMU"]) from None


def _is_fmu(path: Path) -> bool:
    """Whether a path is a file or a folder that an FMU was unpacked into."""
    try:
        return path.is_file() or (path / "modelDescription.xml").is_file()
    except (OSError, ValueError):  # a name that no file system bears
        return False


def is_ready(target: Path | build.Target) -> bool:
    """Whether nothing need be built for it."""
    return isinstance(target, Path) or target.is_current()


def files(targets: Mapping[str, Path | build.Target], progress: Progress) -> dict[str, Path]:
    """
    Give the FMU files of named targets; those that are missing or older than their sources are built.

    Where a native FMU cannot be built here, its model's Python flavour takes its place, and `progress`
    says so.

    Raises:
        ConfigError: If an FMI 3.0 FMU cannot be built here.
    """
    built: dict[build.Target, Path] = {}
    for target in targets.values():
        if isinstance(target, build.Target) and target not in built:
            built[target] = target.path if target.is_current() else _build(target, progress)
    return {name: built[t] if isinstance(t, build.Target) else t for name, t in targets.items()}


def _build(target: build.Target, progress: Progress) -> Path:
    from fmu_sources.export.native import NativeBuildError

    progress(f"building {target.model}.fmu ({target.flavour})")
    try:
        return build.build(target)
    except NativeBuildError as error:
        if target.flavour != "native":
            raise ConfigError([f"{target.model}.fmu: missing or older than its sources; {error}"]) from None
        progress(f"{error}; until then the Python flavour of {target.model} takes its place")
    instead = build.target(target.model, "python")
    return instead.path if instead.is_current() else _build(instead, progress)

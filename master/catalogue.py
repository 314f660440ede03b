"""From a `source` to an FMU file: a path as it is, or a model of `fmu_sources`, built when stale."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from pathlib import Path

from fmu_sources import registry
from fmu_sources.export import build
from fmu_sources.export.native import NativeBuildError

from .errors import ConfigError, expected

Progress = Callable[[str], None]
FLAVOURS = build.FLAVOURS


def silent(model: str) -> None:
    """Show nothing."""


def is_path(source: str) -> bool:
    """Whether a source names a file rather than a model."""
    return source.endswith(".fmu") or "/" in source or "\\" in source


def locate(source: str, folder: Path, flavour: str) -> Path | build.Target:
    """
    Find the FMU of a source; for a model its build target.

    Raises:
        ConfigError: If it is neither a file nor a model.
    """
    if is_path(source):
        path = folder / source
        if not path.is_file():
            raise ConfigError([f"no such file, got {source!r}, expected an FMU at {path}"])
        return path
    try:
        return build.target(source, flavour)
    except KeyError:
        models = expected(source, registry.model_files())
        raise ConfigError([f"no such model, got {source!r}, {models}, or a path to an FMU"]) from None


def build_stale(targets: Iterable[Path | build.Target], progress: Progress) -> None:
    """
    Build each target once that is missing or older than its sources.

    Raises:
        ConfigError: If that needs tools that are not installed.
    """
    unique = {t.path: t for t in targets if isinstance(t, build.Target)}
    for target in unique.values():
        if not target.is_current():
            progress(target.model)
            _build(target)


def _build(target: build.Target) -> None:
    try:
        build.build(target)
    except NativeBuildError as error:
        raise ConfigError(
            [f"{target.model}.fmu: missing or older than its sources; {error}; or take --flavour python"]
        ) from None


def file_of(target: Path | build.Target) -> Path:
    """Path of the FMU file."""
    return target if isinstance(target, Path) else target.path

"""From a `source` to an FMU file: a path as it is, or a model by its name or its file, built when stale."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from pathlib import Path

from fmu_sources.composed import registry
from fmu_sources.composed.names import base_of
from fmu_sources.composed.registry import load, model_files
from fmu_sources.export import build
from fmu_sources.framework.variables import Role

from .errors import ConfigError, expected, shown

Progress = Callable[[str], None]
OWN = ".py"
FLAVOURS = build.FLAVOURS


def silent(text: str) -> None:
    """Show nothing."""


def compensation_methods() -> list[str]:
    """Return the names of the models that are methods of compensation with the same plugs."""
    return [name for name, file in model_files().items() if file.parent.name == "compensators"]


def parameters(model: str) -> dict[str, float]:
    """Return the parameters of a model of the project with their start values."""
    return {v.name: float(v.start) for v in load(model).group(Role.PARAMETER)}


def base_model(source: str) -> str:
    """Return the name of a source's model without effects; a path as it is."""
    return source if is_path(source) else base_of(source)


def is_path(source: str) -> bool:
    """Whether a source names a file rather than a model."""
    return source.lower().endswith((".fmu", OWN)) or "/" in source or "\\" in source


def is_own(source: str) -> bool:
    """Whether a source names the Python file of a model of one's own."""
    return source.lower().endswith(OWN)


def model_name(source: str, target: Path | build.Target) -> str:
    """Return the name of a source's model, found at `target`; the path of a foreign FMU as it is."""
    return source if isinstance(target, Path) else target.model


def locate(source: str, folder: Path, flavour: str) -> Path | build.Target:
    """
    Find the FMU of a source; for a model its build target.

    Raises:
        ConfigError: If it is neither a file nor a model.
    """
    if is_own(source):
        return _own_target(folder / source, flavour)
    if is_path(source):
        path = folder / source
        if not _is_fmu(path):
            raise ConfigError([f"no such file, got {shown(source)}, expected an FMU at {shown(path)}"])
        return path
    try:
        return build.target(source, flavour)
    except KeyError:
        models = expected(source, registry.model_files())
        raise ConfigError([f"no such model, got {shown(source)}, {models}, or a path to an FMU"]) from None


def _own_target(file: Path, flavour: str) -> build.Target:
    from fmu_sources.export.own_model import OwnModelError

    try:
        return build.own_target(file, flavour)
    except OwnModelError as error:
        raise ConfigError(str(error).splitlines()) from None


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
    Return the FMU files of named targets; those that are missing or older than their sources are built.

    Where native FMUs cannot be built here, the Python flavour of their models takes their place, and
    `progress` says so once for the same reason.

    Raises:
        ConfigError: If an FMI 3.0 FMU cannot be built here.
    """
    stale = dict.fromkeys(t for t in targets.values() if isinstance(t, build.Target) and not t.is_current())
    built = _built(stale, progress) if stale else {}
    return {
        name: built.get(target, target.path) if isinstance(target, build.Target) else target
        for name, target in targets.items()
    }


def _built(stale: Iterable[build.Target], progress: Progress) -> dict[build.Target, Path]:
    """Build FMUs, or the Python flavour where a native one cannot be built."""
    from fmu_sources.export.native import NativeBuildError

    built: dict[build.Target, Path] = {}
    failed: dict[str, list[build.Target]] = {}
    for target in stale:
        try:
            built[target] = _build(target, progress)
        except NativeBuildError as error:
            failed.setdefault(str(error), []).append(target)
    _refuse_without_substitute(failed)
    for reason, group in failed.items():
        names = ", ".join(target.model for target in group)
        progress(
            f"{reason}; until then the Python flavour takes the place of {names}, about 1000 times slower"
        )
        for target in group:
            instead = build.target(target.model, "python")
            built[target] = instead.path if instead.is_current() else _build(instead, progress)
    return built


def _build(target: build.Target, progress: Progress) -> Path:
    progress(f"building {target.model}.fmu ({target.flavour})")
    return build.build(target)


def _refuse_without_substitute(failed: Mapping[str, list[build.Target]]) -> None:
    """Refuse what has no Python flavour: FMI 3.0 FMUs, and models by path."""
    problems = [
        f"{target.model}.fmu: missing or older than its sources; {reason}"
        for reason, group in failed.items()
        for target in group
        if target.flavour != "native" or registry.is_own(target.model)
    ]
    if problems:
        raise ConfigError(problems)

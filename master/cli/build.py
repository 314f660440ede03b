"""`dockloop build`: FMUs from sources."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

import click
from rich.progress import track

from fmu_sources.composed import registry
from fmu_sources.export import build as builder
from fmu_sources.export import release as releaser
from fmu_sources.export.manifest import Entry
from fmu_sources.export.native import NativeBuildError
from fmu_sources.export.own_model import OwnModelError, load_model, own_fmu
from fmu_sources.export.places import FMU_FOLDER
from fmu_sources.export.whole_file import write_whole
from master.errors import ConfigError, expected
from master.installation import NATIVE, require, require_native

from .common import FLAVOUR, answers_errors, say
from .console import STDERR


@click.command()
@click.argument("models", nargs=-1, metavar="[MODEL]...")
@FLAVOUR
@click.option(
    "--output",
    type=click.Path(path_type=Path, file_okay=False),
    default=Path(),
    metavar="DIR",
    help="Folder for the FMUs of models given by path; the present one by default.",
)
@click.option(
    "--release",
    is_flag=True,
    help="Build all subsystems for all platforms into fmus/, with a bill of materials.",
)
@click.option(
    "--check", "only_check", is_flag=True, help="Write nothing; fail if an FMU is missing or stale."
)
@answers_errors
def build(models: tuple[str, ...], flavour: str, output: Path, release: bool, only_check: bool) -> None:
    """
    Build the FMUs of MODELs, or of all, where they are missing or stale.

    A MODEL is a name, or the path of a Python file that holds a model as MODEL.
    """
    paths = [Path(model) for model in models if model.endswith(".py")]
    names = [model for model in models if not model.endswith(".py")]
    try:
        if release:
            _release(models, only_check)
            return
        if names or not paths:
            _build(_targets(names, flavour), only_check)
        if paths:
            _build_own(paths, flavour, output, only_check)
    except (NativeBuildError, OwnModelError) as error:
        raise ConfigError(str(error).splitlines()) from None


def _build_own(paths: list[Path], flavour: str, folder: Path, only_check: bool) -> None:
    """Build models that are not of this package, into a folder."""
    require_native("build")
    loaded = {path: load_model(path) for path in paths}
    for path, model in track(loaded.items(), "building", console=STDERR, transient=True):
        content, target = own_fmu(model, flavour, path), folder / f"{model.name}.fmu"
        if only_check:
            _refuse_differences([] if target.is_file() and target.read_bytes() == content else [target])
            continue
        write_whole(target, content)
        say(str(target))


def _targets(models: list[str], flavour: str) -> list[builder.Target]:
    existing = registry.model_files()
    problems = [
        f"MODEL: no such model, got {m!r}, {expected(m, existing)}" for m in models if m not in existing
    ]
    if problems:
        raise ConfigError(problems)
    return [builder.target(name, flavour) for name in models or existing]


def _build(targets: list[builder.Target], only_check: bool) -> None:
    stale = [t for t in targets if not t.is_current()]
    if only_check:
        _refuse_differences(t.path for t in stale)
        say(f"{len(targets)} FMUs are what their sources give")
        return
    if any(target.flavour != "python" for target in stale):
        require_native("build")
    for target in track(stale, "building", console=STDERR, transient=True):
        builder.build(target)
    say(f"{len(stale)} FMUs built, {len(targets) - len(stale)} up to date")


def _release(models: tuple[str, ...], only_check: bool) -> None:
    if models:
        raise ConfigError([f"MODEL: a release holds all subsystems, got {', '.join(models)}, expected none"])
    require(NATIVE, "build --release")
    files: dict[Path, bytes] = {}
    entries: dict[str, Entry] = {}
    steps = track(
        releaser.release_files(),
        "building the release",
        total=len(releaser.release_models()),
        console=STDERR,
        transient=True,
    )
    for built, entry in steps:
        files |= built
        entries |= entry
    if only_check:
        _refuse_differences(releaser.differences(files, entries))
        say(f"{len(files)} FMUs of the release are what their sources give")
        return
    releaser.write_release(files, entries)
    say(f"{len(files)} FMUs of the release written to {FMU_FOLDER.name}/")


def _refuse_differences(paths: Iterable[Path]) -> None:
    problems = [f"{path}: missing or not what its sources give" for path in paths]
    if problems:
        raise ConfigError(problems)

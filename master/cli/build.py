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
from master.errors import ConfigError, expected

from .common import FLAVOUR, answers_errors, say
from .console import STDERR


@click.command()
@click.argument("models", nargs=-1, metavar="[MODEL]...")
@FLAVOUR
@click.option("--release", is_flag=True, help="Build all subsystems for all platforms into fmus/.")
@click.option(
    "--check", "only_check", is_flag=True, help="Write nothing; fail if an FMU is missing or stale."
)
@answers_errors
def build(models: tuple[str, ...], flavour: str, release: bool, only_check: bool) -> None:
    """Build the FMUs of MODELs, or of all, where they are missing or stale."""
    try:
        if release:
            _release(models, only_check)
        else:
            _build(_targets(models, flavour), only_check)
    except NativeBuildError as error:
        raise ConfigError([str(error)]) from None


def _targets(models: tuple[str, ...], flavour: str) -> list[builder.Target]:
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
    for target in track(stale, "building", console=STDERR, transient=True):
        builder.build(target)
    say(f"{len(stale)} FMUs built, {len(targets) - len(stale)} up to date")


def _release(models: tuple[str, ...], only_check: bool) -> None:
    if models:
        raise ConfigError([f"MODEL: a release holds all subsystems, got {', '.join(models)}, expected none"])
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
    say(f"{len(files)} FMUs of the release written to {builder.FMU_FOLDER.name}/")


def _refuse_differences(paths: Iterable[Path]) -> None:
    problems = [f"{path}: missing or not what its sources give" for path in paths]
    if problems:
        raise ConfigError(problems)

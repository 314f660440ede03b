"""`dockloop build`: FMUs from sources."""

from __future__ import annotations

import click
from rich.progress import track

from fmu_sources import registry
from fmu_sources.export import build as builder

from ..errors import ConfigError, expected
from .common import STDERR, answers_errors


@click.command()
@click.argument("models", nargs=-1, metavar="[MODEL]...")
@click.option(
    "--check", "only_check", is_flag=True, help="Build nothing; fail if an FMU is missing or stale."
)
@answers_errors
def build(models: tuple[str, ...], only_check: bool) -> None:
    """Build the FMUs of MODELs, or of all, where they are missing or stale."""
    existing = registry.model_files()
    problems = [
        f"MODEL: no such model, got {m!r}, {expected(m, existing)}" for m in models if m not in existing
    ]
    if problems:
        raise ConfigError(problems)
    targets = [builder.target(name) for name in models or existing]
    stale = [t for t in targets if not t.is_current()]
    if only_check:
        if stale:
            raise ConfigError(f"{t.path}: missing or older than its sources" for t in stale)
        click.echo(f"{len(targets)} FMUs are what their sources give")
        return
    for target in track(stale, "building", console=STDERR, transient=True):
        builder.build(target)
    click.echo(f"{len(stale)} FMUs built, {len(targets) - len(stale)} up to date")

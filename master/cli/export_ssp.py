"""`dockloop export-ssp`: the system as an SSP 1.0 archive."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import click

from master.api import prepare_to_run
from master.experiment.prepare import Request
from master.ssp.export import write_ssp

from .common import answers_errors, calls_fmus, say, show_building, system_options


@click.command("export-ssp")
@system_options
@click.option("--output", type=click.Path(path_type=Path), metavar="FILE", help="The archive to write.")
@answers_errors
@calls_fmus
def export_ssp(config: Path, output: Path | None, **options: Any) -> None:
    """Write CONFIG with its FMUs as an SSP archive; `dockloop run` reads it back."""
    experiment = prepare_to_run(config, Request(**options), show_building)
    parts = filter(None, (experiment.name, experiment.variant))
    name = re.sub(r"[^\w. -]", "_", "-".join(parts)).lstrip(".") or "system"
    path = write_ssp(experiment, output or Path("results") / f"{name[:200]}.ssp")
    say(f"{path}: {len(experiment.system.instances)} FMUs, {len(experiment.system.wires)} connections")

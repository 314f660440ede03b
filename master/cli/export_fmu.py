"""`dockloop export-fmu`: the system as one FMU."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import click

from master.api import prepare_to_run
from master.experiment.prepare import Request
from master.fuse.export import write_fmu

from .common import CONFIG, JSON, SET, STEP_SIZE, VARIANT, answers_errors, print_json, say, show_building

_VERSIONS = {"2": "2.0", "3": "3.0"}


@click.command("export-fmu")
@CONFIG
@VARIANT
@SET
@STEP_SIZE
@click.option(
    "--fmi", type=click.Choice(list(_VERSIONS)), default="2", show_default=True, help="Version of FMI."
)
@click.option("--all-platforms", is_flag=True, help="Compile for Linux, Windows and macOS, with zig.")
@click.option(
    "--output", type=click.Path(path_type=Path, dir_okay=False), metavar="FILE", help="The FMU to write."
)
@JSON
@answers_errors
def export_fmu(
    config: Path, fmi: str, all_platforms: bool, output: Path | None, as_json: bool, **options: Any
) -> None:
    """Write CONFIG as one native FMU with the bits of `dockloop run`, for any tool."""
    experiment = prepare_to_run(config, Request(**options), show_building)
    name = re.sub(r"[^\w. -]", "_", experiment.title.replace(" / ", "-")).lstrip(".") or "system"
    path = output or Path("results") / f"{name[:200]}.fmu"
    written = write_fmu(experiment, path, _VERSIONS[fmi], all_platforms=all_platforms)
    if as_json:
        print_json(
            {
                "fmu": str(written.path),
                "fmi_version": _VERSIONS[fmi],
                "fmus": written.n_fmus,
                "variables": written.n_variables,
                "step_size": experiment.grid.step_size,
            }
        )
        return
    size = f"{written.n_fmus} FMUs, {written.n_variables} variables"
    say(f"{written.path}: FMI {_VERSIONS[fmi]}, {size}, steps of {experiment.grid.step_size:g} s")

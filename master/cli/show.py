"""`dockloop show`: a system as a picture."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from master.errors import ConfigError, Problem
from master.experiment.prepare import Request, prepare
from master.recording.names import folder_name
from master.runs.diagram import save_diagram

from .common import answers_errors, say, show_building, system_options


@click.command()
@system_options
@click.option(
    "--output",
    type=click.Path(path_type=Path, dir_okay=False),
    metavar="FILE",
    help="Picture to write, .svg or .png; the system's name with .svg in this folder by default.",
)
@answers_errors
def show(config: Path, output: Path | None, **options: Any) -> None:
    """Draw CONFIG: its FMUs in the order of stepping, and the age of every value on its wire."""
    if output is not None and output.suffix.lower() not in (".svg", ".png"):
        raise ConfigError(
            [Problem("ending", where="--output", got=repr(output.name), expected=".svg or .png")]
        )
    experiment = prepare(config, Request(**options), show_building)
    say(str(save_diagram(experiment, output or Path(f"{folder_name(experiment.name)}.svg"))))

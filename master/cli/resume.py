"""`dockloop resume`: go on with a run that was interrupted or killed."""

from __future__ import annotations

import sys
from contextlib import ExitStack
from pathlib import Path

import click

from master.runs.resume import resume as go_on

from .common import JSON, answers_errors, say, show_building
from .run import answer, exit_status, shown


@click.command()
@click.argument("folder", type=click.Path(path_type=Path))
@JSON
@answers_errors
def resume(folder: Path, as_json: bool) -> None:
    """Go on with a run made with --checkpoint, from its last checkpoint: the same bits in the end."""
    with ExitStack() as stack:
        resumed = go_on(folder, lambda experiment: lambda: shown(experiment, stack), show_building)
    for note in resumed.notes:
        say(f"note: {note}", err=True)
    say(f"went on after {resumed.tick} steps", err=True)
    answer(resumed.report, as_json)
    sys.exit(exit_status(resumed.report, resumed.interruption))

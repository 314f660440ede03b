"""`dockloop rerun`: repeat a run from its folder; the same bits, or what differs."""

from __future__ import annotations

import sys
from contextlib import ExitStack
from pathlib import Path

import click

from master.errors import EXIT_DIFFERENT
from master.process import signals
from master.runs.repeat import Repeated, repeat

from .common import JSON, answers_errors, print_json, say, show_building
from .run import shown


@click.command()
@click.argument("folder", type=click.Path(path_type=Path))
@click.option(
    "--output",
    type=click.Path(path_type=Path, file_okay=False),
    metavar="DIR",
    help="Keep the results of the second run in this folder.",
)
@JSON
@answers_errors
def rerun(folder: Path, output: Path | None, as_json: bool) -> None:
    """Repeat the run of a results folder: the same bits, or what differs (exit status 1)."""
    with ExitStack() as stack:
        found = repeat(folder, output, lambda experiment: lambda: shown(experiment, stack), show_building)
    if as_json:
        print_json(found.as_dict())
    else:
        _say(folder, found)
    if found.interrupted_by is not None:
        sys.exit(signals.exit_status(found.interrupted_by))
    sys.exit(0 if found.is_same else EXIT_DIFFERENT)


def _say(folder: Path, found: Repeated) -> None:
    if found.is_same and found.comparison is not None:
        n_signals = len(found.comparison.differences)
        say(f"{folder}: same bits in {found.comparison.rows} rows of {n_signals} signals")
    else:
        say(f"{folder}: not the same run")
    for line in found.faults:
        say(f"  {line}")
    for line in found.surroundings:
        say(f"  note: {line}")

"""`dockloop reproduce`: every figure and claim of the paper next to ours, on one page."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from pathlib import Path

import click
from rich.table import Table

from master.reproduce.claims.claim import CONDITION, FAILS, HOLDS
from master.reproduce.reproduction import Reproduction
from master.reproduce.reproduction import reproduce as reproduce_paper

from .common import JSON, answers_errors, calls_fmus, print_json, say, show_building
from .console import STDERR
from .counted import counted_progress

_STYLES = {HOLDS: "green", CONDITION: "yellow", FAILS: "red"}


@click.command()
@click.option(
    "--output",
    type=click.Path(path_type=Path, file_okay=False),
    default=Path("results") / "reproduce",
    show_default=True,
    metavar="DIR",
    help="Folder for the page and the figures.",
)
@click.option(
    "--only",
    multiple=True,
    metavar="ID",
    help="A claim or a figure of the page instead of all, repeated: --only 10 --only ideal.",
)
@JSON
@answers_errors
@calls_fmus
def reproduce(output: Path, only: tuple[str, ...], as_json: bool) -> None:
    """Reproduce the paper: runs of the FMUs for each figure and claim, judged, on one page."""
    with counted_progress() as bar:

        def stage(name: str, total: int) -> Callable[[int], None]:
            task = bar.add_task(name, total=total)
            return lambda n: bar.advance(task, n)

        found = reproduce_paper(output, stage, show_building, only)
    if as_json:
        print_json(found.as_dict())
    else:
        _show(found)


def _show(found: Reproduction) -> None:
    table = Table("claim", "bound", "measured", "verdict", box=None)
    for row in found.rows:
        measured = "-" if row.measured is None else f"{row.measured:.4g}"
        table.add_row(row.id, row.bound, measured, row.verdict, style=_STYLES[row.verdict])
    STDERR.print(table)
    for verdict, n in Counter(row.verdict for row in found.rows).items():
        say(f"{n:>4} {verdict}")
    for text in found.changed:
        say(f"judged otherwise before: {text}")
    say(found.files["page"])

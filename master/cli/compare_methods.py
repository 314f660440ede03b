"""`dockloop compare-methods`: methods of compensation in cells, one table."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import click

from master.comparison.cells import SHIPPED, read_cells
from master.comparison.compare import Score, check, compare, tasks
from master.comparison.methods import chosen
from master.comparison.page import shown, write_page
from master.installation import configuration

from .common import JSON, answers_errors, calls_fmus, print_json, say, show_building
from .counted import counted_progress

CASES = ("low_frequency", "high_frequency", "experiment", "experiment_1000kg")


@click.command("compare-methods")
@click.argument("configs", nargs=-1, type=click.Path(path_type=Path))
@click.option("--methods", default="all", show_default=True, metavar="A,B", help="Methods by name, or all.")
@click.option(
    "--cells",
    type=click.Path(path_type=Path, dir_okay=False),
    default=SHIPPED,
    show_default="those that are shipped",
    metavar="FILE",
    help="YAML file of cells.",
)
@click.option("--seeds", type=click.IntRange(1, 1000), default=5, show_default=True, help="Noises a cell.")
@click.option(
    "--processes", type=click.IntRange(1, 256), default=2, show_default=True, help="Runs at a time."
)
@click.option(
    "--output",
    type=click.Path(path_type=Path, file_okay=False),
    default=Path("results") / "compare-methods",
    show_default=True,
    metavar="DIR",
    help="Folder for the page.",
)
@JSON
@answers_errors
@calls_fmus
def compare_methods(
    configs: tuple[Path, ...],
    methods: str,
    cells: Path,
    seeds: int,
    processes: int,
    output: Path,
    as_json: bool,
) -> None:
    """Compare methods of compensation in the cells of CONFIGS (those of the paper): NRMSE in percent."""
    paths = [configuration(config) for config in configs or map(Path, CASES)]
    work = tasks(paths, read_cells(cells), chosen(methods), seeds)
    check(work, show_building)
    with counted_progress() as bar:
        task = bar.add_task("cells by methods", total=len(work))
        scores = compare(work, lambda n: bar.advance(task, n), processes)
    page = output / "comparison.html"
    write_page(scores, seeds, page)
    if as_json:
        print_json({"cells": [score.as_dict() for score in scores]})
        return
    say(_table(scores))
    say(f"s_des/s_act in percent, worst of {seeds} seeds; page: {page}")


def _table(scores: Sequence[Score]) -> str:
    """Return a row a cell, a column a method."""
    names = list(dict.fromkeys(score.method for score in scores))
    rows: dict[tuple[str, str], list[str]] = {}
    for score in scores:
        rows.setdefault((score.config, score.cell), []).append(shown(score))
    lines = [["configuration", "cell", *names], *([*place, *texts] for place, texts in rows.items())]
    widths = [max(map(len, column)) for column in zip(*lines, strict=True)]
    return "\n".join(
        "  ".join(text.ljust(width) for text, width in zip(line, widths, strict=True)).rstrip()
        for line in lines
    )

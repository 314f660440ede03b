"""`dockloop run`: step a system, show progress, save and summarise."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import click
from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn

from .. import simulation
from ..errors import EXIT_DIVERGED, EXIT_FMU
from ..experiment import Experiment, Request, prepare
from ..report import Report, save_run, summary_lines
from .common import CONFIG, FLAVOUR, JSON, SET, STDERR, VARIANT, answers_errors, print_json, show_building

_EXIT = {
    simulation.COMPLETED: 0,
    simulation.DIVERGED: EXIT_DIVERGED,
    simulation.FAILED: EXIT_FMU,
    simulation.INTERRUPTED: 130,
}


@click.command()
@CONFIG
@VARIANT
@SET
@click.option("--stop-time", type=float, metavar="T", help="Stop at T seconds instead of the file's time.")
@FLAVOUR
@click.option(
    "--output",
    type=click.Path(path_type=Path, file_okay=False),
    metavar="DIR",
    help="Folder for the results.",
)
@JSON
@answers_errors
def run(config: Path, output: Path | None, as_json: bool, **options: Any) -> None:
    """Step the system that CONFIG describes and save what it computes."""
    request = Request(**options)
    experiment = prepare(config, request, show_building)
    outcome = _simulate(experiment)
    folder = output or Path("results") / experiment.config.name / (request.variant or "default")
    report = save_run(experiment, outcome, folder)
    _answer(report, as_json)
    sys.exit(_EXIT[outcome.status])


def _simulate(experiment: Experiment) -> simulation.Outcome:
    columns = (
        TextColumn("{task.description}"),
        BarColumn(),
        TextColumn("{task.fields[t]}"),
        TimeRemainingColumn(),
    )
    step = experiment.grid.step_size
    with Progress(*columns, console=STDERR, transient=True) as bar:
        task = bar.add_task(experiment.config.name, total=experiment.grid.n_ticks, t="")

        def advance(ticks: int) -> None:
            bar.update(task, advance=ticks)
            bar.update(task, t=f"t = {bar.tasks[task].completed * step:.2f} s")

        return simulation.simulate(
            experiment.system,
            experiment.schedule,
            experiment.grid,
            limits=experiment.limits,
            progress=advance,
        )


def _answer(report: Report, as_json: bool) -> None:
    if as_json:
        print_json(report.as_dict())
    else:
        for line in summary_lines(report):
            click.echo(line)
    if report.message:
        click.echo(report.message, err=True)

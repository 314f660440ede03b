"""`dockloop run`: step a system, show progress, save and summarise."""

from __future__ import annotations

import math
import sys
import time
from contextlib import nullcontext
from pathlib import Path
from typing import Any

import click
from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn

from master.api import prepare_to_run
from master.errors import EXIT_DIVERGED, EXIT_FMU
from master.evaluation.report import Report, save_run, summary_lines
from master.experiment.experiment import Experiment
from master.experiment.prepare import Request
from master.recording.files import ResultFiles
from master.stepping import simulate
from master.stepping.outcome import (
    COMPLETED,
    DIVERGED,
    FAILED,
    INTERRUPTED,
    OVERRUN,
    TERMINATED,
    Outcome,
    RunOptions,
)
from master.stepping.pacing import CONTINUE, STOP, Pacer

from .common import (
    CONFIG,
    FLAVOUR,
    JSON,
    SET,
    STDERR,
    STEP_SIZE,
    VARIANT,
    answers_errors,
    print_json,
    show_building,
)

_EXIT = {
    COMPLETED: 0,
    TERMINATED: 0,
    DIVERGED: EXIT_DIVERGED,
    FAILED: EXIT_FMU,
    OVERRUN: EXIT_FMU,
    INTERRUPTED: 130,
}
_ROWS_IN_MEMORY = 100_000
_SECONDS_A_LOOK = 0.1


SLOWEST = 1e-6
FASTEST = 1e9


def _pace(_: click.Context, __: click.Parameter, value: float | None) -> float | None:
    if value is not None and not SLOWEST <= value <= FASTEST:
        raise click.BadParameter(f"not a pace, got {value:g}, expected from {SLOWEST:g} to {FASTEST:g}")
    return value


@click.command()
@CONFIG
@VARIANT
@SET
@click.option("--stop-time", type=float, metavar="T", help="Stop at T seconds instead of the file's time.")
@STEP_SIZE
@FLAVOUR
@click.option(
    "--output",
    type=click.Path(path_type=Path, file_okay=False),
    metavar="DIR",
    help="Folder for the results.",
)
@click.option(
    "--real-time",
    type=float,
    is_flag=False,
    flag_value=1.0,
    callback=_pace,
    metavar="[FACTOR]",
    help="Pace the ticks on the clock, FACTOR simulated seconds a second (1).",
)
@click.option(
    "--on-overrun",
    type=click.Choice([CONTINUE, STOP]),
    default=CONTINUE,
    show_default=True,
    help="What to do when a tick is not done in time.",
)
@JSON
@answers_errors
def run(config: Path, output: Path | None, as_json: bool, **options: Any) -> None:
    """Step the system that CONFIG describes and save what it computes."""
    factor, on_overrun = options.pop("real_time"), options.pop("on_overrun")
    request = Request(**options)
    experiment = prepare_to_run(config, request, show_building)
    folder = output or Path("results") / experiment.name / (request.variant or "default")
    pacer = None if factor is None else Pacer(factor, on_overrun)
    long = experiment.grid.n_ticks > _ROWS_IN_MEMORY
    with ResultFiles(folder) if long else nullcontext() as streamed:
        outcome = _simulate(experiment, pacer, streamed)
    _answer(save_run(experiment, outcome, folder, streamed), as_json)
    sys.exit(_EXIT[outcome.status])


def _simulate(experiment: Experiment, pacer: Pacer | None, sink: ResultFiles | None) -> Outcome:
    columns = (
        TextColumn("{task.description}", markup=False),
        BarColumn(),
        TextColumn("{task.fields[t]}"),
        TimeRemainingColumn(),
    )
    grid = experiment.grid
    options = RunOptions(
        limits=experiment.limits,
        compared=experiment.compared,
        scenario=experiment.scenario,
        pacer=pacer,
        sink=sink,
        keep_every=1 if sink is None else math.ceil(grid.n_ticks / _ROWS_IN_MEMORY),
    )
    with Progress(*columns, console=STDERR, transient=True) as bar:
        task = bar.add_task(experiment.name, total=grid.n_ticks, t="")
        done, shown = 0, 0.0

        def advance(ticks: int) -> None:
            nonlocal done, shown
            done += ticks
            if time.monotonic() - shown >= _SECONDS_A_LOOK:  # in real time each tick comes here
                shown = time.monotonic()
                bar.update(task, completed=done, t=f"t = {grid.time(done):.2f} s")

        return simulate.simulate(
            experiment.system, experiment.schedule, grid, options=options, progress=advance
        )


def _answer(report: Report, as_json: bool) -> None:
    if as_json:
        print_json(report.as_dict())
    else:
        for line in summary_lines(report):
            click.echo(line)
    if report.message:
        click.echo(report.message, err=True)

"""`dockloop run`: step a system, show progress, save and summarise."""

from __future__ import annotations

import math
import signal
import sys
import time
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import click
from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn

from master.api import prepare_to_run
from master.errors import EXIT_DIVERGED, EXIT_FMU
from master.evaluation.report import Report, load_libraries, save_run, summary_lines
from master.experiment.experiment import Experiment
from master.experiment.prepare import Request
from master.fmi.messages import LEVELS, LogFile
from master.process import signals
from master.process.signals import Interruption
from master.recording.files import ResultFiles
from master.recording.folder import LOG, OutputFolder
from master.recording.names import results_folder
from master.stepping.apart import simulate_apart
from master.stepping.outcome import (
    COMPLETED,
    DIVERGED,
    FAILED,
    INTERRUPTED,
    OVERRUN,
    TERMINATED,
    Outcome,
    ProgressCallback,
    RunOptions,
)
from master.stepping.pacing import CONTINUE, STOP, Pacer
from master.text.printable import printable

from .common import (
    CONFIG,
    FLAVOUR,
    INPUTS,
    JSON,
    SET,
    STEP_SIZE,
    VARIANT,
    answers_errors,
    print_json,
    say,
    show_building,
)
from .console import STDERR

_EXIT = {
    COMPLETED: 0,
    TERMINATED: 0,
    DIVERGED: EXIT_DIVERGED,
    FAILED: EXIT_FMU,
    OVERRUN: EXIT_FMU,
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
@INPUTS
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
@click.option(
    "--log",
    "level",
    type=click.Choice(["none", *LEVELS]),
    default="warning",
    show_default=True,
    help="Which messages of FMUs go to a file, if there are any.",
)
@JSON
@answers_errors
def run(config: Path, output: Path | None, as_json: bool, **options: Any) -> None:
    """Step the system that CONFIG describes and save what it computes."""
    factor, on_overrun, level = options.pop("real_time"), options.pop("on_overrun"), options.pop("level")
    request = Request(**options)
    experiment = prepare_to_run(config, request, show_building)
    given = (*request.assignments, *(() if request.inputs is None else (f"inputs={request.inputs.name}",)))
    path = output or results_folder(experiment.name, request.variant, given)
    pacer = None if factor is None else Pacer(factor, on_overrun)
    with signals.noted() as interruption, OutputFolder(path) as folder:
        is_long = experiment.grid.n_ticks > _ROWS_IN_MEMORY
        streamed = ResultFiles(path) if is_long else None
        log_file = None if level == "none" else LogFile(folder.path / LOG, level)
        outcome = _simulate(experiment, pacer, streamed, interruption, log_file)
        if log_file is not None:
            log_file.close()
        report = save_run(experiment, outcome, folder, streamed, interruption)
    _answer(report, as_json)
    sys.exit(_exit_status(report, interruption))


def _exit_status(report: Report, interruption: Interruption) -> int:
    if report.status == INTERRUPTED:
        return signals.exit_status(interruption.number or signal.SIGINT)
    return _EXIT[report.status]


def _simulate(
    experiment: Experiment,
    pacer: Pacer | None,
    sink: ResultFiles | None,
    interruption: Interruption,
    log_file: LogFile | None,
) -> Outcome:
    grid = experiment.grid
    options = RunOptions(
        limits=experiment.limits,
        compared=experiment.compared,
        scenario=experiment.scenario,
        inputs=experiment.inputs,
        pacer=pacer,
        sink=sink,
        keep_every=1 if sink is None else math.ceil(grid.n_ticks / _ROWS_IN_MEMORY),
    )
    with ExitStack() as stack:
        return simulate_apart(
            experiment.system,
            experiment.schedule,
            grid,
            options,
            interruption,
            lambda: _shown(experiment, stack),
            log_file,
            load_libraries,
        )


def _shown(experiment: Experiment, stack: ExitStack) -> ProgressCallback:
    """Show a progress bar until the stack ends; return what moves it on."""
    grid = experiment.grid
    columns = (
        TextColumn("{task.description}", markup=False),
        BarColumn(),
        TextColumn("{task.fields[t]}"),
        TimeRemainingColumn(),
    )
    bar = stack.enter_context(Progress(*columns, console=STDERR, transient=True))
    task = bar.add_task(printable(experiment.config.name), total=grid.n_ticks, t="")
    done, shown = 0, 0.0

    def advance(ticks: int) -> None:
        nonlocal done, shown
        done += ticks
        if time.monotonic() - shown >= _SECONDS_A_LOOK:  # in real time each tick comes here
            shown = time.monotonic()
            bar.update(task, completed=done, t=f"t = {grid.time(done):.2f} s")

    return advance


def _answer(report: Report, as_json: bool) -> None:
    if as_json:
        print_json(report.as_dict())
    else:
        for line in summary_lines(report):
            say(line)
    if report.message:
        say(report.message, err=True)

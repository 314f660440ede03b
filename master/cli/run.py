"""`dockloop run`: step a system, show progress, save and summarise."""

from __future__ import annotations

import re
import signal
import sys
import time
from contextlib import ExitStack
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import click
from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn

from master.api import prepare_to_run
from master.errors import EXIT_DIVERGED, EXIT_FMU, EXIT_STOPPED, ConfigError, Problem
from master.evaluation.report import Report, summary_lines
from master.experiment.experiment import Experiment
from master.experiment.prepare import Request
from master.fmi.messages import LEVELS
from master.installation import configuration
from master.process import signals
from master.process.signals import Interruption
from master.recording.names import results_folder
from master.runs.execute import run_into
from master.runs.manifest import Checkpointing, Described
from master.runs.resume import OPTION, require_possible
from master.stepping.outcome import (
    COMPLETED,
    DIVERGED,
    FAILED,
    INTERRUPTED,
    OVERRUN,
    STOPPED,
    TERMINATED,
    ProgressCallback,
)
from master.stepping.pacing import CONTINUE, STOP, Pacer
from master.text.printable import printable

from .common import INPUTS, JSON, answers_errors, print_json, say, show_building, system_options
from .console import STDERR

_EXIT = {
    COMPLETED: 0,
    TERMINATED: 0,
    DIVERGED: EXIT_DIVERGED,
    STOPPED: EXIT_STOPPED,
    FAILED: EXIT_FMU,
    OVERRUN: EXIT_FMU,
}
_SECONDS_A_LOOK = 0.1


SLOWEST = 1e-6
FASTEST = 1e9
SHORTEST = 0.01
LONGEST = 3.6e6

_TIME = re.compile(r"(?P<number>[0-9]+\.?[0-9]*|\.[0-9]+) ?(?P<unit>ms|s|min|h)?", re.ASCII)
_SECONDS = {"ms": 1e-3, "s": 1.0, "min": 60.0, "h": 3600.0}


def _pace(_: click.Context, __: click.Parameter, value: float | None) -> float | None:
    if value is not None and not SLOWEST <= value <= FASTEST:
        raise click.BadParameter(f"not a pace, got {value:g}, expected from {SLOWEST:g} to {FASTEST:g}")
    return value


def _interval(_: click.Context, __: click.Parameter, value: str | None) -> float | None:
    if value is None:
        return None
    expected = "a time from 10 ms to 1000 h, as 60s, 5min or 1h"
    match = _TIME.fullmatch(value.strip())
    seconds = float(match["number"]) * _SECONDS[match["unit"] or "s"] if match else 0.0
    if not SHORTEST <= seconds <= LONGEST:
        raise click.BadParameter(f"not a time between checkpoints, got {value!r}, expected {expected}")
    return seconds


@click.command()
@system_options
@INPUTS
@click.option("--stop-time", type=float, metavar="T", help="Stop at T seconds instead of the file's time.")
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
    "--priority",
    type=click.IntRange(1, 99),
    metavar="P",
    help="In real time: step with priority P of SCHED_FIFO (needs CAP_SYS_NICE or an rtprio limit).",
)
@click.option(
    "--core",
    type=click.IntRange(min=0),
    metavar="N",
    help="In real time: step on processor N alone.",
)
@click.option(
    "--log",
    "level",
    type=click.Choice(["none", *LEVELS]),
    default="warning",
    show_default=True,
    help="Which messages of FMUs go to a file, if there are any.",
)
@click.option(
    "--record",
    multiple=True,
    metavar="SIGNAL",
    help="Save this output alone; may be repeated for others.",
)
@click.option(
    "--every",
    type=click.IntRange(min=1),
    metavar="N",
    help="Save every N-th row, from the first one on.",
)
@click.option(
    "--isolate",
    multiple=True,
    metavar="all|FMU,...",
    help="Give these FMUs a process of their own, which a fault ends alone.",
)
@click.option(
    "--sandbox",
    is_flag=True,
    help="Isolate FMUs (all, unless --isolate names some) without network and without writing outside their "
    "folder.",
)
@click.option("--page", is_flag=True, help="Write a page (run.html), too.")
@click.option(
    "--checkpoint",
    callback=_interval,
    metavar="TIME",
    help="Make a checkpoint each TIME (60s, 5min), from which `dockloop resume` goes on.",
)
@JSON
@answers_errors
def run(config: Path, output: Path | None, as_json: bool, page: bool, **options: Any) -> None:
    """Step the system that CONFIG describes and save what it computes."""
    factor, on_overrun, level = options.pop("real_time"), options.pop("on_overrun"), options.pop("level")
    interval = options.pop("checkpoint")
    priority, core = options.pop("priority"), options.pop("core")
    if factor is None and not (priority is None and core is None):
        where = "--core" if priority is None else "--priority"
        raise ConfigError([Problem("not in real time", where=where, got="no --real-time", expected="both")])
    if interval is not None and factor is not None:
        expected = "one of both: a run beside hardware cannot go on later"
        raise ConfigError([Problem("in real time", where=OPTION, got="--real-time", expected=expected)])
    request = Request(**options)
    started = datetime.now(UTC)
    experiment = prepare_to_run(config, request, show_building)
    given = (*request.assignments, *(() if request.inputs is None else (f"inputs={request.inputs.name}",)))
    path = output or results_folder(experiment.name, request.variant, given)
    pacer = None if factor is None else Pacer(factor, on_overrun, priority, core)
    log = None if level == "none" else level
    described = Described(str(config), configuration(config), request, experiment, started)
    if interval is not None:
        require_possible(experiment)
        described.checkpoints = Checkpointing(interval=interval, log=log, page=page)
    with ExitStack() as stack:
        report, interruption = run_into(
            described, path, lambda: shown(experiment, stack), pacer, log, page=page
        )
    answer(report, as_json)
    sys.exit(exit_status(report, interruption))


def exit_status(report: Report, interruption: Interruption) -> int:
    """Return the exit status of a command that made a run."""
    if report.status == INTERRUPTED:
        return signals.exit_status(interruption.number or signal.SIGINT)
    return _EXIT[report.status]


def shown(experiment: Experiment, stack: ExitStack) -> ProgressCallback:
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


def answer(report: Report, as_json: bool) -> None:
    """Print the summary of a run."""
    if as_json:
        print_json(report.as_dict())
    else:
        for line in summary_lines(report):
            say(line)
    if report.message:
        say(report.message, err=True)

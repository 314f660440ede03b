"""`dockloop sweep`: a campaign of runs, their dataset and their page."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import click

from master.campaign.plan import make_plan
from master.campaign.stepper import FAILURES
from master.campaign.sweep import Progress, Shown
from master.campaign.sweep import sweep as make_runs
from master.campaign.swept import Swept
from master.errors import EXIT_FMU
from master.process import signals
from master.text.printable import printable

from .common import JSON, answers_errors, print_json, say, show_building


@click.command()
@click.argument("campaign", type=click.Path(path_type=Path))
@click.option("--workers", type=click.IntRange(1, 1024), metavar="N", help="Processes here (one a core).")
@click.option("--scheduler", metavar="ADDRESS", help="Dask cluster that makes the runs, as tcp://host:8786.")
@click.option(
    "--output",
    type=click.Path(path_type=Path, file_okay=False),
    metavar="DIR",
    help="Folder for dataset and page.",
)
@click.option("--resume", is_flag=True, help="Make the runs that are missing in DIR.")
@JSON
@answers_errors
def sweep(
    campaign: Path,
    workers: int | None,
    scheduler: str | None,
    output: Path | None,
    resume: bool,
    as_json: bool,
) -> None:
    """Run the system of CAMPAIGN with varied values, and answer how often and why it goes wrong."""
    plan = make_plan(campaign, show_building)
    folder = output or Path("results") / f"sweep-{campaign.stem}"
    n = workers or len(os.sched_getaffinity(0))
    with _shown(plan.name) as shown:
        found = make_runs(plan, folder, n, scheduler=scheduler, resume=resume, shown=shown)
    if as_json:
        print_json(found.as_dict())
    else:
        _say(found)
    sys.exit(_exit_status(found))


def _exit_status(found: Swept) -> int:
    if found.interruption is not None:
        return signals.exit_status(found.interruption)
    failed = sum(found.statuses.get(status, 0) for status in FAILURES)
    return EXIT_FMU if failed and failed == found.runs else 0


def _say(found: Swept) -> None:
    counts = ", ".join(f"{n} {status}" for status, n in found.statuses.items()) or "none"
    say(f"{found.runs} of {found.planned} runs: {counts}")
    if found.tuned is not None:
        known = found.tuned
        values = ", ".join(f"{name} = {value:.6g}" for name, value in known["values"].items())
        broken = "" if known["is_feasible"] else ", which breaks a constraint"
        say(f"tuned by {known['runs']} runs: {values}; objective {known['objective']}{broken}")
    if found.ended:
        say(f"ended early: {found.ended}")
    if found.interval is not None:
        known = found.interval
        say(f"{known['measure']}: {known['value']:.4g}, interval {known['low']:.4g} to {known['high']:.4g}")
    if found.fused:
        say(f"{found.fused} of these runs in the fused form: the system compiled as one, with the same bits")
    for why, n in found.apart.items():
        say(f"{n} of them with the FMUs apart: {why}")
    if found.discarded:
        say(
            f"{found.discarded} rows discarded and their runs made again: the fused form had shown other bits"
        )
    say(f"{found.wall_s:.1f} s, {100 * found.stepping_share:.0f} % of it in stepping")
    say(f"dataset: {found.dataset}")
    if found.page:
        say(f"page: {found.page}")


@contextmanager
def _shown(name: str) -> Iterator[Shown]:
    """Show a bar with the time left, failures, and the interval of the measure."""
    from rich.progress import BarColumn, MofNCompleteColumn, TextColumn, TimeRemainingColumn
    from rich.progress import Progress as Bar

    from .console import STDERR

    columns = (
        TextColumn("{task.description}", markup=False),
        BarColumn(),
        MofNCompleteColumn(),
        TimeRemainingColumn(),
        TextColumn("{task.fields[said]}", markup=False),
    )
    with Bar(*columns, console=STDERR, auto_refresh=False) as bar:  # no thread: processes are forked
        task = bar.add_task(printable(name), total=None, said="")

        def show(progress: Progress) -> None:
            known = progress.interval
            said = f"{progress.failures} failed"
            if known is not None:
                said += f", {progress.measure} {known.value:.4g} +- {known.half_width:.2g}"
            bar.update(task, completed=progress.done, total=progress.total, said=said)
            bar.refresh()

        yield show

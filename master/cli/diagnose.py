"""`dockloop diagnose`: measured data, the residual, what the model lacks, before and after."""

from __future__ import annotations

import time
from pathlib import Path
from typing import Any

import click
from rich.progress import Progress, SpinnerColumn, TextColumn, TimeElapsedColumn

from master.errors import ConfigError
from master.installation import require_native
from master.text.printable import printable

from .common import JSON, answers_errors, calls_fmus, print_json, say
from .console import STDERR


@click.command()
@click.argument("case", type=click.Path(path_type=Path))
@click.option("--output", type=click.Path(path_type=Path), help="Folder of the results.")
@click.option("--budget", type=float, metavar="SECONDS", help="Stop searching then, with the best so far.")
@JSON
@answers_errors
@calls_fmus
def diagnose(case: Path, output: Path | None, budget: float | None, as_json: bool) -> None:
    """Say what the model of CASE lacks, add it, and show the error before and after."""
    require_native("diagnose")
    from master.diagnosis.answer.answer import answer
    from master.diagnosis.search.deadline import Deadline

    if budget is not None and not budget > 0.0:
        raise ConfigError([f"--budget: got {budget:g} s, expected a positive time"])
    deadline = Deadline(budget)
    begin = time.monotonic()
    folder = output or Path("results") / "diagnosis" / case.stem
    columns = (SpinnerColumn(), TextColumn("{task.description}", markup=False), TimeElapsedColumn())
    with Progress(*columns, console=STDERR, transient=True) as bar:
        task = bar.add_task(printable(case.stem))

        def show(text: str) -> None:
            bar.update(task, description=printable(text))
            if not STDERR.is_terminal:  # a log wants lines
                say(f"{time.monotonic() - begin:8.1f} s  {text}", err=True)

        report = answer(case, folder, show, deadline, lambda cost: say(cost, err=True))
    if as_json:
        print_json(report)
        return
    for line in _lines(report, folder):
        say(line)


def _lines(report: dict[str, Any], folder: Path) -> list[str]:
    lines = [report["sentence"], f"verdict: {report['verdict']}; subsystem: {report['subsystem'] or 'none'}"]
    for name, before in report["before"].items():
        after = report["after"][name]
        if before["rmse"] is not None and after["rmse"] is not None:
            lines.append(
                f"{name}: rmse {before['rmse']:.4g} -> {after['rmse']:.4g} "
                f"({before['nrmse_percent']:.3g} -> {after['nrmse_percent']:.3g} %) on the sealed part"
            )
    for family in report["undistinguished"]:
        lines.append(f"not told apart: {' or '.join(family['family'])}. {family['experiment']}")
    return [*lines, f"files in {folder}"]

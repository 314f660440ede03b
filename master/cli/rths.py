"""`dockloop rths`: the benchmark of real-time hybrid simulation, its nine measures."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from contextlib import closing
from pathlib import Path

import click

from master.errors import EXIT_DIVERGED, ConfigError
from master.process.child import done_apart
from master.rths.benchmark import (
    CASES,
    CLOSED_FORM,
    CONFIGURATIONS,
    METHODS,
    Benchmark,
    Score,
    leagues,
    next_score,
)
from master.rths.measures import N_MEASURES
from master.rths.record import read_record
from master.runs.kept_runs import KeptRuns

from .common import JSON, answers_errors, print_json, say, show_building
from .counted import counted_progress

SCALE = 0.4
"""Share of the published records that the benchmark takes."""
LEAGUES = tuple(dict.fromkeys(league for _, league in CONFIGURATIONS))


@click.command()
@click.option(
    "--case",
    type=click.IntRange(min(CASES), max(CASES)),
    default=1,
    show_default=True,
    help="Floor mass and damping of the building.",
)
@click.option(
    "--record",
    type=click.Path(path_type=Path),
    default=None,
    show_default=CLOSED_FORM,
    metavar="FILE",
    help="Ground motion: time [s] and acceleration [m/s2] as two rows or columns.",
)
@click.option(
    "--scale",
    type=click.FloatRange(min=0.0, min_open=True),
    default=SCALE,
    show_default=True,
    help="Factor on the record.",
)
@click.option("--method", type=click.Choice(METHODS), default="robust", show_default=True)
@click.option(
    "--league",
    type=click.Choice(LEAGUES),
    default=None,
    show_default="the first that the method has",
    help="What the method may change: the command alone, as the rules say, or the force too.",
)
@click.option("--noise", type=click.Choice(["on", "off"]), default="on", show_default=True)
@click.option(
    "--perturbed",
    type=click.IntRange(0, 1000),
    default=0,
    show_default=True,
    help="Number of perturbed plants after the nominal one.",
)
@JSON
@answers_errors
def rths(
    case: int,
    record: Path | None,
    scale: float,
    method: str,
    league: str | None,
    noise: str,
    perturbed: int,
    as_json: bool,
) -> None:
    """Run the RTHS benchmark with a method of compensation: J1 to J9 against the undivided building."""
    known = leagues(method)
    if league is not None and league not in known:
        raise ConfigError([f"--league: not with the method {method}, got {league!r}, expected {known[0]!r}"])
    task = Benchmark(
        method=method,
        league=league or known[0],
        case=case,
        record=None if record is None else read_record(record, scale),
        with_noise=noise == "on",
    )
    scores = done_apart(lambda: _scores(task, perturbed + 1))
    if as_json:
        print_json(_as_dict(task, scores))
    else:
        say(_table(task, scores))
    if any(one.J is None for one in scores):
        sys.exit(EXIT_DIVERGED)


def _scores(task: Benchmark, n_plants: int) -> list[Score]:
    found = []
    with counted_progress() as bar, closing(KeptRuns()) as runs:
        counted = bar.add_task("plants", total=n_plants)
        for seed in range(n_plants):
            found.append(next_score(runs, task, seed, show_building))
            bar.advance(counted)
    return found


def _as_dict(task: Benchmark, scores: Sequence[Score]) -> dict[str, object]:
    nominal, *others = scores
    return {
        "case": task.case,
        "record": task.record_name,
        "method": task.method,
        "league": task.league,
        "status": nominal.status,
        "J": nominal.J,
        "floor": nominal.floor,
        "perturbed": [one.J for one in others],
        "plants": [one.plant for one in others],
    }


def _table(task: Benchmark, scores: Sequence[Score]) -> str:
    """Return a row a plant, a column a measure."""
    names = ["nominal", *(f"plant {i}" for i in range(1, len(scores)))]
    rows = [_row(name, one) for name, one in zip(names, scores, strict=True)]
    finished = [one.J for one in scores[1:] if one.J is not None]
    if finished:
        worst = [max(values) for values in zip(*finished, strict=True)]
        rows.append("worst".ljust(10) + _numbers(worst))
    head = "".ljust(10) + "".join(f"J{i}".rjust(9) for i in range(1, N_MEASURES + 1))
    place = f"case {task.case}, {task.record_name}, method {task.method}, league {task.league}"
    title = f"{place}: J1 in ms, others in %"
    floor = scores[0].floor
    last = [] if floor is None else [f"the noise of the transducer alone makes a J4 of {floor:.2f} %"]
    return "\n".join([title, head, *rows, *last])


def _row(name: str, one: Score) -> str:
    return name.ljust(10) + (one.status if one.J is None else _numbers(one.J))


def _numbers(values: Sequence[float]) -> str:
    return "".join(f"{value:9.2f}" for value in values)

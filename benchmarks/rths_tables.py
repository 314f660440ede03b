"""
The tables of docs/rths.md: every method and league under every record, in all cases, on perturbed plants.

    python benchmarks/rths_tables.py FOLDER [--plants 20] [--first 1] [--methods robust] [--cases 1 4]

FOLDER holds the records of the benchmark. Rows go to the error stream as they are found; a run takes 0.2 to
0.4 s of processor time.
"""

from __future__ import annotations

import argparse
import sys
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path

from master.cli.rths import SCALE
from master.rths.benchmark import (
    CASES,
    CONFIGURATIONS,
    DISPLACEMENT,
    FORCE,
    METHODS,
    Benchmark,
    Score,
    next_score,
)
from master.rths.record import read_record
from master.runs.kept_runs import KeptRuns

RECORDS = {
    "El Centro": "ElCentroAccelNoScaling.mat",
    "Kobe": "KobeAccelNoScaling.mat",
    "Morgan Hill": "MorganAccelNoScaling.mat",
}
N_PLANTS = 20
OF_PERTURBED = (1, 2, 4, 6, 8)
"""Measures of the table of perturbed plants."""


@dataclass(frozen=True)
class Found:
    """A row of each table: nominal plant, and the worst of the perturbed ones."""

    nominal: str
    worst: str


def main() -> None:
    """Print both tables."""
    asked = argparse.ArgumentParser(description=__doc__.strip().splitlines()[0])
    asked.add_argument("folder", type=Path)
    asked.add_argument("--plants", type=int, default=N_PLANTS)
    asked.add_argument("--first", type=int, default=1, help="number of the first perturbed plant")
    asked.add_argument("--methods", default=",".join(METHODS))
    asked.add_argument("--records", default=",".join(RECORDS))
    asked.add_argument("--leagues", nargs="+", default=[DISPLACEMENT, FORCE])
    asked.add_argument("--cases", type=int, nargs="+", default=CASES)
    given = asked.parse_args()
    plants = range(given.first, given.first + given.plants)
    methods = given.methods.split(",")
    rows = []
    for name in given.records.split(","):
        record = read_record(given.folder / RECORDS[name], SCALE)
        for case in given.cases:
            for method, league in CONFIGURATIONS:
                if method in methods and league in given.leagues:
                    rows.append(_row(name, Benchmark(method, league, case, record, True), plants))
                    print(rows[-1].nominal, rows[-1].worst, sep="\n", file=sys.stderr, flush=True)
    print("\n".join(row.nominal for row in rows))
    print()
    print("\n".join(row.worst for row in rows))


def _row(name: str, task: Benchmark, plants: range) -> Found:
    with closing(KeptRuns()) as runs:
        nominal = next_score(runs, task, 0)
        others = [next_score(runs, task, seed) for seed in plants]
    place = f"| {name} | {task.case} |"
    method = f"`{task.method}` | {task.league} |"
    floor = f" {nominal.floor:.2f} |" if nominal.floor is not None else " - |"
    worst = _worst(others)
    numbers = " - |" * len(OF_PERTURBED) if worst is None else _cells([worst[i - 1] for i in OF_PERTURBED])
    return Found(
        f"{place}{floor} {method}{_cells(nominal.J or [])}",
        f"{place} {method} {plants[0]} to {plants[-1]} |{floor}{numbers}",
    )


def _worst(scores: list[Score]) -> list[float] | None:
    """Return the largest of each measure, None if a run diverged."""
    values = [score.J for score in scores]
    if any(value is None for value in values):
        return None
    return [max(column) for column in zip(*(v for v in values if v is not None), strict=True)]


def _cells(values: list[float]) -> str:
    return "".join(f" {value:.2f} |" for value in values)


if __name__ == "__main__":
    main()

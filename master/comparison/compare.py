"""All runs of a comparison, by as many processes as asked for."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from concurrent.futures import as_completed
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from master.api import prepare_to_run
from master.catalogue import Progress, silent
from master.errors import ConfigError
from master.experiment.experiment import Experiment
from master.process.workers import workers
from master.stepping.outcome import COMPLETED, DIVERGED, RunOptions
from master.stepping.simulate import simulate
from master.system.config import Config, LoadedConfig
from master.text.validation import validate
from master.text.yaml_lines import Document

from .cells import Cell
from .methods import Method
from .systems import Base, system

LARGEST = 10.0
"""Motion in terms of the largest one of the reference beyond which a run has diverged."""


@dataclass(frozen=True)
class Task:
    """One method in one cell of one configuration, with all seeds."""

    base: Path
    cell_name: str
    cell: Cell
    method: Method
    seeds: tuple[int, ...]


@dataclass(frozen=True)
class Score:
    """NRMSE [%] of displacement and reproduced motion, worst of the seeds; None unless all runs completed."""

    config: str
    cell: str
    method: str
    s_des: float | None
    s_act: float | None
    status: str

    def as_dict(self) -> dict[str, Any]:
        """Return what `--json` prints."""
        return {
            "config": self.config,
            "cell": self.cell,
            "method": self.method,
            "s_des": self.s_des,
            "s_act": self.s_act,
            "status": self.status,
        }


def tasks(
    configs: Sequence[Path], cells: dict[str, Cell], methods: Sequence[Method], n_seeds: int
) -> list[Task]:
    """
    List the work, cell by cell.

    Raises:
        ConfigError: If a configuration or a cell is wrong, or nothing is left to do.
    """
    problems: list[str] = []
    found: list[Task] = []
    seeds = tuple(range(1, n_seeds + 1))
    for path in configs:
        try:
            base = Base(path)
        except ConfigError as error:
            problems += error.problems
            continue
        for name, cell in cells.items():
            if cell.configs is not None and base.name not in cell.configs:
                continue
            try:
                system(base, cell, methods[0], 1)
            except ConfigError as error:
                problems += [f"cells.{name} in {base.name}: {problem}" for problem in error.problems]
            found += [Task(path, name, cell, method, seeds) for method in methods]
    if not problems and not found:
        problems.append("cells: none is for these configurations")
    if problems:
        raise ConfigError(problems)
    return found


def check(work: Sequence[Task], progress: Progress = silent) -> None:
    """
    Prepare one run of each cell and of each method, so that no process finds an FMU missing or a cell wrong.

    Raises:
        ConfigError: With the faults of the cells.
    """
    problems: list[str] = []
    seen: set[tuple[str, str]] = set()
    for task in work:
        keys = {("cell", f"{task.base}{task.cell_name}"), ("method", task.method.name)}
        if keys <= seen:
            continue
        seen |= keys
        try:
            _prepared(task, task.seeds[0], progress)
        except ConfigError as error:
            problems += [f"cells.{task.cell_name} in {task.base.stem}: {text}" for text in error.problems]
    if problems:
        raise ConfigError(list(dict.fromkeys(problems)))


def compare(work: Sequence[Task], done: Callable[[int], None], processes: int) -> list[Score]:
    """Make all runs; `done` is told how many tasks have ended. Scores are in the order of the work."""
    if processes <= 1 or len(work) == 1:
        scores = []
        for task in work:
            scores.append(score(task))
            done(1)
        return scores
    with workers(min(processes, len(work)), "spawn") as pool:
        futures = {pool.submit(score, task): i for i, task in enumerate(work)}
        found: dict[int, Score] = {}
        for future in as_completed(futures):
            found[futures[future]] = future.result()
            done(1)
    return [found[i] for i in range(len(work))]


def score(task: Task) -> Score:
    """Run a task in this process."""
    runs = [_run(task, seed) for seed in task.seeds]
    statuses = {status for status, _, _ in runs}
    bad = DIVERGED if DIVERGED in statuses else next(iter(sorted(statuses - {COMPLETED})), None)
    names = task.base.stem, task.cell_name, task.method.name
    if bad is not None:
        return Score(*names, None, None, bad)
    return Score(*names, max(s for _, s, _ in runs), max(s for _, _, s in runs), COMPLETED)


def _prepared(task: Task, seed: int, progress: Progress = silent) -> Experiment:
    document = Document(task.base, system(Base(task.base), task.cell, task.method, seed))
    found = validate(Config, document, "system")
    if found.model is None:
        raise ConfigError(found.problems)
    return prepare_to_run(LoadedConfig(found.model, found.document, found.problems), progress=progress)


def _run(task: Task, seed: int) -> tuple[str, float, float]:
    """Return status and NRMSE [%] of signal and reproduced motion."""
    experiment = _prepared(task, seed)
    judged = experiment.compare
    assert judged is not None
    options = RunOptions(
        limits=experiment.limits,
        compared=experiment.compared,
        scenario=experiment.scenario,
        inputs=experiment.inputs,
    )
    outcome = simulate(experiment.system, experiment.schedule, experiment.grid, options=options)
    if outcome.status != COMPLETED:
        return outcome.status, math.nan, math.nan
    result = outcome.result
    reference = result[str(judged.reference)]
    size = np.sqrt(np.mean(reference**2))
    motions = [result[str(name)] for name in (judged.signal, judged.reproduced)]
    if np.max(np.abs(motions)) > LARGEST * np.max(np.abs(reference)):
        return DIVERGED, math.nan, math.nan
    errors = [100.0 * float(np.sqrt(np.mean((motion - reference) ** 2)) / size) for motion in motions]
    return outcome.status, errors[0], errors[1]

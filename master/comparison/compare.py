"""All runs of a comparison, by as many processes as asked for."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from concurrent.futures import as_completed
from contextlib import closing
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from master.api import prepare_to_run
from master.catalogue import Progress, silent
from master.errors import ConfigError
from master.experiment.experiment import Experiment
from master.fmi.description import Description
from master.process.workers import each_needed, workers
from master.runs.kept_runs import KeptRuns
from master.stepping.outcome import COMPLETED, DIVERGED
from master.system.config import Config, LoadedConfig
from master.system.graph import with_values
from master.text.validation import validate
from master.text.yaml_lines import Document

from .cells import Cell
from .methods import Method
from .systems import Base, seeds, system

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
class Run:
    """How a run ended, and the NRMSE [%] of displacement and reproduced motion if it completed."""

    status: str
    s_des: float = math.nan
    s_act: float = math.nan


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
    judge = Judge()
    problems: list[str] = []
    seen: set[tuple[str, str]] = set()
    for task in work:
        keys = {("cell", f"{task.base}{task.cell_name}"), ("method", task.method.name)}
        if keys <= seen:
            continue
        seen |= keys
        try:
            judge.prepared(task, task.seeds[0], progress)
        except ConfigError as error:
            problems += [f"cells.{task.cell_name} in {task.base.stem}: {text}" for text in error.problems]
    if problems:
        raise ConfigError(list(dict.fromkeys(problems)))


def compare(work: Sequence[Task], done: Callable[[int], None], processes: int) -> list[Score]:
    """
    Make all runs; `done` is told how many tasks have ended. Scores are in the order of the work.

    What has the same FMUs goes to the same process, which keeps them loaded: a method in a configuration.
    """
    groups: dict[tuple[Path, str], list[int]] = {}
    for i, task in enumerate(work):
        groups.setdefault((task.base, task.method.name), []).append(i)
    found: dict[int, Score] = {}
    if processes <= 1 or len(groups) == 1:
        for places in groups.values():
            with closing(Judge()) as judge:
                for i in places:
                    found[i] = judge.score(work[i])
                    done(1)
        return [found[i] for i in range(len(work))]
    with each_needed(), workers(min(processes, len(groups)), "spawn") as pool:
        futures = {pool.submit(scores, [work[i] for i in g]): g for g in groups.values()}
        for future in as_completed(futures):
            places = futures[future]
            found |= dict(zip(places, future.result(), strict=True))
            done(len(places))
    return [found[i] for i in range(len(work))]


def scores(work: Sequence[Task]) -> list[Score]:
    """Run tasks in this process, one after the other."""
    with closing(Judge()) as judge:
        return [judge.score(task) for task in work]


class Judge:
    """Prepares runs, makes them and judges them; what runs share is read and loaded once."""

    def __init__(self) -> None:
        self._runs = KeptRuns()
        self._bases: dict[Path, Base] = {}
        self._descriptions: dict[str, Description] = {}

    def score(self, task: Task) -> Score:
        """Run a task, with all its seeds."""
        first = self.prepared(task, task.seeds[0])
        runs = [self._run(self._seeded(task, first, seed)) for seed in task.seeds]
        statuses = {run.status for run in runs}
        bad = DIVERGED if DIVERGED in statuses else next(iter(sorted(statuses - {COMPLETED})), None)
        names = task.base.stem, task.cell_name, task.method.name
        if bad is not None:
            return Score(*names, None, None, bad)
        return Score(*names, max(run.s_des for run in runs), max(run.s_act for run in runs), COMPLETED)

    def close(self) -> None:
        """End the FMUs."""
        self._runs.close()

    def prepared(self, task: Task, seed: int, progress: Progress = silent) -> Experiment:
        """
        Prepare a run of a task.

        Raises:
            ConfigError: With what is wrong in the cell.
        """
        document = Document(task.base, system(self._base(task.base), task.cell, task.method, seed))
        found = validate(Config, document, "system")
        if found.model is None:
            raise ConfigError(found.problems)
        loaded = LoadedConfig(found.model, found.document, found.problems)
        sources = {name: entry.source for name, entry in found.model.fmus.items()}
        read = self._descriptions
        known = {name: read[source] for name, source in sources.items() if source in read}
        experiment = prepare_to_run(loaded, progress=progress, given=known)
        for name, source in sources.items():
            read[source] = experiment.system.instances[name].description
        return experiment

    def _base(self, path: Path) -> Base:
        if path not in self._bases:
            self._bases[path] = Base(path)
        return self._bases[path]

    def _seeded(self, task: Task, first: Experiment, seed: int) -> Experiment:
        """Return a run that was prepared with another seed; events have seeds that are no values."""
        if seed == task.seeds[0]:
            return first
        if task.cell.events:
            return self.prepared(task, seed)
        values = seeds(self._base(task.base), task.cell, seed)
        return replace(first, system=with_values(first.system, values))

    def _run(self, experiment: Experiment) -> Run:
        judged = experiment.compare
        assert judged is not None
        outcome = self._runs.run(experiment)
        if outcome.status != COMPLETED:
            return Run(outcome.status)
        result = outcome.result
        reference = result[str(judged.reference)]
        size = np.sqrt(np.mean(reference**2))
        motions = [result[str(name)] for name in (judged.signal, judged.reproduced)]
        if np.max(np.abs(motions)) > LARGEST * np.max(np.abs(reference)):
            return Run(DIVERGED)
        s_des, s_act = (100.0 * float(np.sqrt(np.mean((s - reference) ** 2)) / size) for s in motions)
        return Run(COMPLETED, s_des, s_act)

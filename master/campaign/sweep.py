"""A campaign from its plan to its folder: missing runs are made, rows go to the dataset as they come."""

from __future__ import annotations

import json
import time
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, Protocol

import numpy as np

from master.errors import ConfigError, DataError, Problem
from master.process import signals
from master.recording.folder import reason
from master.recording.lock import FileLock, Held
from master.recording.whole_file import write_whole

from .cluster import Cluster
from .crew import Crew, Order, require_fork
from .dataset import RUNS, Dataset, read_columns
from .fused import FUSED
from .interval import Interval, Running
from .page import write_page
from .plan import DIVERGED_SHARE, Plan
from .proven import NOT_EXACT
from .stepper import FAILURES, Row
from .swept import Swept
from .tune import at_optimum, tune

MANIFEST, SUMMARY, PAGE = "campaign.json", "summary.json", "campaign.html"
_IS_APART = "is_apart"  # key of the manifest: the fused form has shown other bits

_FLUSH_SECONDS = 1.0
_FLUSH_SHARE = 0.05  # of the time since the beginning, so that a long campaign has few files
_LOCK = ".dockloop.lock"


class Engine(Protocol):
    """What makes runs: processes here, or a cluster."""

    def rows(self, orders: Iterator[Order], is_over: Callable[[], bool]) -> Iterator[Row | None]:
        """Make runs; see `Crew.rows`."""
        ...

    def close(self) -> None:
        """End what makes runs."""
        ...


@dataclass(frozen=True)
class Progress:
    """How far a campaign is: runs done of all, those that failed, and the interval of its measure."""

    done: int
    total: int
    failures: int
    measure: str
    interval: Interval | None


Shown = Callable[[Progress], None]


def sweep(
    plan: Plan,
    folder: Path,
    workers: int,
    *,
    scheduler: str | None = None,
    resume: bool = False,
    shown: Shown | None = None,
    page: bool = True,
) -> Swept:
    """
    Make the runs of a campaign that are missing, and answer what it asks.

    Args:
        plan: The campaign.
        folder: For dataset, page and summary.
        workers: Number of processes here.
        resume: Go on with a campaign that is in the folder.
        scheduler: Address of a Dask cluster that makes the runs instead.
        shown: Told how far it is.
        page: Whether a page is written.

    Raises:
        DataError: If the folder cannot be written, or holds a campaign and is not to be resumed.
        ConfigError: If it holds another campaign, the cluster cannot make the runs, or this system cannot
            fork the processes that would.
    """
    if scheduler is None or plan.campaign.tune is not None:
        require_fork(plan.name)
    with _held(folder), signals.noted() as interruption:
        tuned = None
        if plan.campaign.tune is not None:
            tuned = tune(plan, folder, workers, lambda: bool(interruption))
            if tuned is None:
                return _interrupted(plan, folder, interruption.number)
            plan = at_optimum(plan, tuned)
        dataset = _opened(plan, folder, resume=resume)
        engine, n = _engine(plan, workers, scheduler)
        course = _Course(plan, folder, dataset, engine, n, shown, lambda: bool(interruption))
        try:
            course.run()
        finally:
            engine.close()
        found = course.result(folder)
        found.interruption = interruption.number
        found.tuned = None if tuned is None else asdict(tuned)
        if found.runs and page:
            found.page = str(write_page(plan, found, folder, folder / PAGE))
        write_whole(folder / SUMMARY, json.dumps(found.as_dict(), indent=2))
    return found


def _interrupted(plan: Plan, folder: Path, number: int | None) -> Swept:
    """Return what a search that was asked to end has come to: no runs."""
    return Swept(
        runs=0,
        statuses={},
        wall_s=0.0,
        stepping_share=0.0,
        dataset=str(folder / RUNS),
        page=None,
        planned=plan.sample.n_runs,
        ended="interrupted",
        interruption=number,
    )


def _engine(plan: Plan, workers: int, scheduler: str | None) -> tuple[Engine, int]:
    """Return what makes the runs, and how many it makes at a time."""
    if scheduler is None:
        return Crew(plan, workers), workers
    cluster = Cluster(plan, scheduler)
    return cluster, cluster.cores


class _Course:
    """The runs of one command."""

    def __init__(
        self,
        plan: Plan,
        folder: Path,
        dataset: Dataset,
        engine: Engine,
        workers: int,
        shown: Shown | None,
        is_interrupted: Callable[[], bool],
    ) -> None:
        self.plan = plan
        self.folder = folder
        self.dataset = dataset
        self.engine = engine
        self.workers = workers
        self.shown = shown
        self.is_interrupted = is_interrupted
        until = plan.campaign.until
        self.measure = DIVERGED_SHARE if until is None else until.measure
        self._forget()
        self.wall = 0.0
        self.stepping = 0.0
        self.made: Counter[str] = Counter()
        self.ended = ""
        self.is_apart = bool(_manifest(folder).get(_IS_APART))
        self.known_apart = np.zeros_like(dataset.done)
        self.discarded = 0

    def run(self) -> None:
        self._recall()
        began = time.monotonic()
        if not self._is_narrow():
            self._make(began)
        if self.discarded and not self.ended:
            self._make(began)  # what was removed
        self.wall = time.monotonic() - began
        self.dataset.flush()
        self._show()

    def _make(self, began: float) -> None:
        """Make the runs that have no row."""
        missing = np.flatnonzero(~self.dataset.done)
        orders = (Order(int(run), is_apart=self.is_apart) for run in missing)
        flushed = time.monotonic()
        for row in self.engine.rows(orders, self._is_over):
            if row is not None:
                self._take(row)
            now = time.monotonic()
            if now - flushed > max(_FLUSH_SECONDS, _FLUSH_SHARE * (now - began)):
                self.dataset.flush()
                flushed = now
            if row is None:
                self._show()

    def _take(self, row: Row) -> None:
        """Take a row, unless it is of a process that has not heard yet that the fused form is not exact."""
        if row.made == NOT_EXACT and not self.is_apart:
            self._doubt()
        if self.is_apart and row.made == FUSED:
            return
        if self.dataset.add(row):
            self.known_apart[row.run] = row.made not in (FUSED, "")
            self._count(row)
            self.made[row.made] += 1

    def _doubt(self) -> None:
        """Remove all rows but those made with the FMUs by this command, and use the fused form no more."""
        self.is_apart = True
        self.discarded = self.dataset.keep_only(self.known_apart)
        _write_manifest(self.folder, {**_manifest(self.folder), _IS_APART: True})
        self.made[FUSED] = self.made[""] = 0
        self._forget()
        self._recall()

    def _forget(self) -> None:
        """Begin to count."""
        until = self.plan.campaign.until
        confidence = 0.95 if until is None else until.confidence
        self.running = Running(is_share=self.measure == DIVERGED_SHARE, confidence=confidence)
        self.statuses: Counter[str] = Counter()

    def result(self, folder: Path) -> Swept:
        interval = self.running.interval()
        told = None if interval is None else {"measure": self.measure, **asdict(interval)}
        return Swept(
            runs=sum(self.statuses.values()),
            statuses=dict(sorted(self.statuses.items())),
            wall_s=self.wall,
            stepping_share=self.stepping / (self.wall * self.workers) if self.wall > 0.0 else 0.0,
            dataset=str(self.dataset.path),
            page=None,
            planned=self.plan.sample.n_runs,
            ended=self.ended,
            interval=told,
            restarts=getattr(self.engine, "restarts", 0),
            fused=self.made[FUSED],
            apart={why: n for why, n in sorted(self.made.items()) if n and why not in (FUSED, "")},
            discarded=self.discarded,
        )

    def _recall(self) -> None:
        """Count the rows that an earlier command left."""
        if not self.dataset.done.any():
            return
        names = [] if self.measure == DIVERGED_SHARE else [self.measure]
        columns = read_columns(self.dataset.path, ["run", "status", *names])
        statuses = columns["status"].tolist()
        values = columns[names[0]].tolist() if names else [None] * len(statuses)
        for run, status, value in zip(columns["run"].tolist(), statuses, values, strict=True):
            self._count(Row(run, status, numbers={self.measure: value}))

    def _count(self, row: Row) -> None:
        self.statuses[row.status] += 1
        self.stepping += row.stepping
        self.running.add(row.number(self.measure))

    def _is_over(self) -> bool:
        if self.is_interrupted():
            self.ended = "interrupted"
            return True
        return self._is_narrow()

    def _is_narrow(self) -> bool:
        """Whether the interval of the measure is as narrow as it has to be."""
        until = self.plan.campaign.until
        interval = self.running.interval()
        if until is None or interval is None or interval.n < until.fewest:
            return False
        if interval.half_width > until.half_width:
            return False
        self.ended = f"{until.measure} is known within {interval.half_width:.4g}"
        return True

    def _show(self) -> None:
        if self.shown is not None:
            failures = sum(self.statuses[status] for status in FAILURES)
            done = sum(self.statuses.values())
            total = self.plan.sample.n_runs
            self.shown(Progress(done, total, failures, self.measure, self.running.interval()))


@contextmanager
def _held(folder: Path) -> Iterator[None]:
    """Hold the folder while its dataset grows."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
        lock = FileLock(folder / _LOCK)
        lock.fill(64)
    except Held as held:
        raise DataError(
            f"{folder}: another campaign writes here, got process {held.pid}, expected a folder of its own"
        ) from None
    except (OSError, ValueError) as error:
        raise DataError(f"{folder}: cannot be written: {reason(error)}") from None
    try:
        yield
    finally:
        lock.release()


def _manifest(folder: Path) -> dict[str, Any]:
    """Read what a campaign's folder says of the campaign."""
    found: dict[str, Any] = json.loads((folder / MANIFEST).read_text(encoding="utf-8"))
    return found


def _write_manifest(folder: Path, told: dict[str, Any]) -> None:
    try:
        write_whole(folder / MANIFEST, json.dumps(told, indent=2))
    except OSError as error:
        raise DataError(f"{folder}: cannot be written: {reason(error)}") from None


def _opened(plan: Plan, folder: Path, *, resume: bool) -> Dataset:
    """Open the dataset of the folder; it must be new, or of this campaign."""
    manifest = folder / MANIFEST
    known: dict[str, Any] = {}
    if manifest.is_file():
        if not resume:
            raise DataError(f"{folder}: holds a campaign already, expected --resume or another folder")
        known = _manifest(folder)
        if known.get("digest") != plan.digest:
            expected = "the campaign, system and FMUs that it was begun with"
            raise ConfigError(
                [Problem("another campaign", where=str(folder), got=plan.name, expected=expected)]
            )
    told = {"name": plan.name, "digest": plan.digest, "planned": plan.sample.n_runs}
    _write_manifest(folder, {**known, **told})
    return Dataset(folder, plan)

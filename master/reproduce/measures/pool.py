"""All runs, each made once, as many at a time as there are processors."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Mapping
from concurrent.futures import as_completed
from concurrent.futures.process import BrokenProcessPool

from master.fmi import unpacked
from master.process.workers import workers

from .runs import Recording, Run, Wanted, experiment_of, perform

CHUNK = 10

Wishes = Mapping[Run, Wanted]
Recordings = dict[Run, Recording]
Progress = Callable[[int], None]


def merged(wishes: Iterable[Wishes]) -> dict[Run, Wanted]:
    """Join what several ask of the same runs."""
    found: dict[Run, Wanted] = {}
    for wish in wishes:
        for run, wanted in wish.items():
            found[run] = found.get(run, Wanted()) | wanted
    return found


def build_fmus(wishes: Wishes, say: Callable[[str], None]) -> None:
    """Build what is missing before two processes find it missing; prepare each configuration once."""
    for config in dict.fromkeys(run.config for run in wishes):
        experiment_of(Run(config), say)


def processors() -> int:
    """Count the processors that this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def perform_all(wishes: Wishes, progress: Progress, processes: int | None = None) -> Recordings:
    """
    Make all runs.

    Args:
        wishes: What to keep of each run.
        progress: Called with the number of runs done since its last call.
        processes: How many work at once; None: one for each processor.
    """
    runs = sorted(wishes, key=lambda r: (r.config, r.variant or "", r.values, str(r.order), r.seed))
    parts = [{r: wishes[r] for r in runs[i : i + CHUNK]} for i in range(0, len(runs), CHUNK)]
    processes = min(processes or processors(), len(parts))
    if processes <= 1:
        return _one_by_one(parts, progress)
    found: Recordings = {}
    try:
        with workers(processes, "spawn") as pool:
            for future in as_completed([pool.submit(perform_part, part) for part in parts]):
                part = future.result()
                found |= part
                progress(len(part))
    except BrokenProcessPool:  # an FMU ended a worker: where a command runs, it is known which one
        missing = [part for part in parts if not part.keys() <= found.keys()]
        found |= _one_by_one(missing, progress)
    return found


def perform_part(wishes: Wishes) -> Recordings:
    """Make some runs in this process."""
    with unpacked.kept():
        return {run: perform(run, wanted) for run, wanted in wishes.items()}


def _one_by_one(parts: Iterable[Wishes], progress: Progress) -> Recordings:
    found: Recordings = {}
    for part in parts:
        found |= perform_part(part)
        progress(len(part))
    return found

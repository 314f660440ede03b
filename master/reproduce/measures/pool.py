"""All runs, each made once, two at a time."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from concurrent.futures import as_completed

from master.process.workers import workers

from .runs import Recording, Run, Wanted, experiment_of, perform

N_PROCESSES = 2
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


def perform_all(wishes: Wishes, progress: Progress, processes: int = N_PROCESSES) -> Recordings:
    """Make all runs; `progress` is called with the number of runs done since the last call."""
    runs = sorted(wishes, key=lambda r: (r.config, r.variant or "", r.values, str(r.order), r.seed))
    parts = [{r: wishes[r] for r in runs[i : i + CHUNK]} for i in range(0, len(runs), CHUNK)]
    if processes <= 1:
        return _one_by_one(parts, progress)
    found: Recordings = {}
    with workers(processes, "spawn") as pool:
        for future in as_completed([pool.submit(perform_part, part) for part in parts]):
            part = future.result()
            found |= part
            progress(len(part))
    return found


def perform_part(wishes: Wishes) -> Recordings:
    """Make some runs in this process."""
    return {run: perform(run, wanted) for run, wanted in wishes.items()}


def _one_by_one(parts: Iterable[Wishes], progress: Progress) -> Recordings:
    found: Recordings = {}
    for part in parts:
        found |= perform_part(part)
        progress(len(part))
    return found

"""A run from a prepared system to a folder with results, summary and manifest."""

from __future__ import annotations

import math
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

from master.errors import FmuError
from master.evaluation.report import Report, load_libraries, save_run
from master.fmi.messages import LogFile
from master.process import signals
from master.process.signals import Interruption
from master.recording.checkpoints import (
    CheckpointFiles,
    Durable,
    read_checkpoint,
    remove_checkpoint,
)
from master.recording.files import ResultFiles
from master.recording.folder import LOG, OutputFolder
from master.recording.selection import SelectedRows
from master.stepping.apart import simulate_apart
from master.stepping.outcome import (
    COMPLETED,
    DIVERGED,
    FAILED,
    TERMINATED,
    Outcome,
    ProgressCallback,
    RunOptions,
)
from master.stepping.pacing import Pacer
from master.stepping.recorded import recorded_ports

from .manifest import RUNNING, Described, write_manifest

ROWS_IN_MEMORY = 100_000
BYTES_IN_MEMORY = 2**28
AT_ITS_END = (COMPLETED, DIVERGED, TERMINATED)
"""Statuses of a run that would end the same way if it went on again."""

Shown = Callable[[], ProgressCallback]


def rows_in_memory(n_signals: int) -> int:
    """Return how many rows a run keeps in memory at most: of a wide system fewer."""
    return min(ROWS_IN_MEMORY, max(1, BYTES_IN_MEMORY // (8 * max(1, n_signals))))


def run_into(
    described: Described,
    path: Path,
    progress: Shown,
    pacer: Pacer | None = None,
    level: str | None = None,
    *,
    page: bool = False,
    goes_on: bool = False,
) -> tuple[Report, Interruption]:
    """
    Step a system and save what it computes.

    Args:
        described: The system and how it was asked for.
        path: Folder for the results; what an older run left there is removed.
        progress: Begins to show progress; returns what is called with the number of ticks done.
        pacer: Paces the ticks on the clock.
        level: Which messages of FMUs go to a file; None for none.
        page: Whether to write a page with plots, parameters and manifest.
        goes_on: Whether to go on from the last checkpoint in the folder, if there is one yet.

    Returns:
        The summary, and the signals that came meanwhile.

    Raises:
        DataError: If the folder cannot be written, or its checkpoint is damaged.
        FmuError: If an FMU cannot be loaded or initialised; the folder has a manifest that says so.
    """
    experiment = described.experiment
    with signals.noted() as interruption, OutputFolder(path, goes_on=goes_on) as folder:
        last = read_checkpoint(path) if goes_on else None
        most_rows = rows_in_memory(len(recorded_ports(experiment.system)))
        is_long = experiment.grid.n_ticks > most_rows or described.checkpoints is not None
        streamed = ResultFiles(path, mark=None if last is None else last.mark.files) if is_long else None
        log_file = None if level is None else LogFile(folder.path / LOG, level, goes_on=last is not None)
        durable = None
        if described.checkpoints is not None and streamed is not None:
            files = CheckpointFiles(path, 0 if last is None else last.mark.n_kept)
            durable = Durable(described.checkpoints.interval, files, streamed, last)
            write_manifest(described.manifest(RUNNING, 0, folder.path), folder.path)
        run = _Run(described, pacer, streamed, interruption, log_file, durable)
        try:
            outcome = run.simulate(progress)
        except FmuError:
            _describe_failure(described, folder)
            raise
        if log_file is not None:
            log_file.close()

        def more(outcome: Outcome, folder: OutputFolder) -> dict[str, str]:
            manifest = described.manifest(outcome.status, outcome.steps, folder.shown)
            files = {"manifest": str(write_manifest(manifest, folder.shown))}
            if page:
                from .run_page import write_page

                files["page"] = str(write_page(experiment, outcome, manifest, folder.shown))
            return files

        report = save_run(experiment, outcome, folder, streamed, interruption, more)
        if report.status in AT_ITS_END:
            with suppress(OSError):  # it is of no use, and harms nobody
                remove_checkpoint(folder.path)
        return report, interruption


def _describe_failure(described: Described, folder: OutputFolder) -> None:
    """Leave a manifest of a run without rows, if the disk takes it: the failure itself is told anyway."""
    try:
        write_manifest(described.manifest(FAILED, 0, folder.path), folder.path)
    except OSError:
        return


@dataclass(frozen=True)
class _Run:
    """What a run needs besides its system."""

    described: Described
    pacer: Pacer | None
    streamed: ResultFiles | None
    interruption: Interruption
    log_file: LogFile | None
    durable: Durable | None

    def simulate(self, progress: Shown) -> Outcome:
        """Step the system."""
        experiment = self.described.experiment
        grid = experiment.grid
        first_row = 0
        if self.durable is not None and self.durable.begin_at is not None:
            first_row = self.durable.begin_at.mark.n_rows
        sink = None
        keep_every = 1
        if self.streamed is not None:
            sink = SelectedRows(experiment.selection, self.streamed, first_row)
            most_rows = rows_in_memory(len(recorded_ports(experiment.system)))
            keep_every = max(1, math.ceil(grid.n_ticks / most_rows))
        options = RunOptions(
            limits=experiment.limits,
            compared=experiment.compared,
            scenario=experiment.scenario,
            inputs=experiment.inputs,
            pacer=self.pacer,
            sink=sink,
            keep_every=keep_every,
            durable=self.durable,
        )

        def meanwhile() -> None:
            load_libraries()
            self.described.look()

        return simulate_apart(
            experiment.system,
            experiment.schedule,
            grid,
            options,
            self.interruption,
            progress,
            self.log_file,
            meanwhile,
        )

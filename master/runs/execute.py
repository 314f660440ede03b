"""A run from a prepared system to a folder with results, summary and manifest."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path

from master.errors import FmuError
from master.evaluation.report import Report, load_libraries, save_run
from master.fmi.messages import LogFile
from master.process import signals
from master.process.signals import Interruption
from master.recording.files import ResultFiles
from master.recording.folder import LOG, OutputFolder
from master.recording.selection import SelectedRows
from master.stepping.apart import simulate_apart
from master.stepping.outcome import FAILED, Outcome, ProgressCallback, RunOptions
from master.stepping.pacing import Pacer

from .manifest import Described, write_manifest

ROWS_IN_MEMORY = 100_000

Shown = Callable[[], ProgressCallback]


def run_into(
    described: Described,
    path: Path,
    progress: Shown,
    pacer: Pacer | None = None,
    level: str | None = None,
    *,
    page: bool = False,
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

    Returns:
        The summary, and the signals that came meanwhile.

    Raises:
        DataError: If the folder cannot be written.
        FmuError: If an FMU cannot be loaded or initialised; the folder has a manifest that says so.
    """
    experiment = described.experiment
    with signals.noted() as interruption, OutputFolder(path) as folder:
        is_long = experiment.grid.n_ticks > ROWS_IN_MEMORY
        streamed = ResultFiles(path) if is_long else None
        log_file = None if level is None else LogFile(folder.path / LOG, level)
        try:
            outcome = _simulated(described, pacer, streamed, interruption, log_file, progress)
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

        return save_run(experiment, outcome, folder, streamed, interruption, more), interruption


def _describe_failure(described: Described, folder: OutputFolder) -> None:
    """Leave a manifest of a run without rows, if the disk takes it: the failure itself is told anyway."""
    try:
        write_manifest(described.manifest(FAILED, 0, folder.path), folder.path)
    except OSError:
        return


def _simulated(
    described: Described,
    pacer: Pacer | None,
    streamed: ResultFiles | None,
    interruption: Interruption,
    log_file: LogFile | None,
    progress: Shown,
) -> Outcome:
    experiment = described.experiment
    grid = experiment.grid
    options = RunOptions(
        limits=experiment.limits,
        compared=experiment.compared,
        scenario=experiment.scenario,
        inputs=experiment.inputs,
        pacer=pacer,
        sink=None if streamed is None else SelectedRows(experiment.selection, streamed),
        keep_every=1 if streamed is None else math.ceil(grid.n_ticks / ROWS_IN_MEMORY),
    )

    def meanwhile() -> None:
        load_libraries()
        described.look()

    return simulate_apart(
        experiment.system,
        experiment.schedule,
        grid,
        options,
        interruption,
        progress,
        log_file,
        meanwhile,
    )

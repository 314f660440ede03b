"""A run that was interrupted or killed, taken up again from its last checkpoint: the same bits in the end."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path

from master.catalogue import Progress, silent
from master.errors import ConfigError, DataError
from master.evaluation.report import Report
from master.experiment.experiment import Experiment
from master.process.child import IS_POSSIBLE
from master.process.signals import Interruption
from master.recording.checkpoints import read_checkpoint
from master.stepping.snapshot import require_serialisable

from .execute import AT_ITS_END, Shown, run_into
from .manifest import RUNNING, Resumption, read_manifest
from .repeat import changed_inputs, described_again, surroundings

OPTION = "--checkpoint"


@dataclass(frozen=True)
class Resumed:
    """What a resumed run came to: it went on after `tick` ticks; `notes` say what else is new."""

    report: Report
    interruption: Interruption
    tick: int
    notes: list[str]


def require_possible(experiment: Experiment) -> None:
    """
    Refuse a system of which no checkpoints can be made.

    Raises:
        ConfigError: With each FMU that cannot hand over its state, or if runs have no process of their own.
    """
    if not IS_POSSIBLE:
        raise ConfigError([f"{OPTION}: the run has no process of its own on this system, expected Linux"])
    require_serialisable(experiment.system, OPTION)


def resume(folder: Path, progress: Callable[[Experiment], Shown], building: Progress = silent) -> Resumed:
    """
    Go on with the run of a results folder.

    Args:
        folder: Results of a run with checkpoints that has not come to its end.
        progress: Returns for a system what begins to show progress.
        building: Told what is built.

    Raises:
        ConfigError: If the configuration, an FMU or a recording has changed since, with each of them.
        DataError: If the folder holds no such run, another process writes there, or a file is damaged.
        FmuError: If an FMU cannot be loaded, initialised, or does not take its state.
    """
    first = read_manifest(folder)
    if first.checkpoints is None:
        raise DataError(f"{folder}: a run without checkpoints, expected one made with {OPTION}")
    if first.status in AT_ITS_END:
        expected = "one that was interrupted or failed"
        raise DataError(f"{folder}: the run has come to its end, got {first.status}, expected {expected}")
    described = described_again(first, building)
    changed = changed_inputs(first, described.look())
    if changed:
        raise ConfigError(changed)
    require_possible(described.experiment)
    checkpoint = read_checkpoint(folder)
    tick = 0 if checkpoint is None else checkpoint.mark.n_rows - 1
    now = datetime.now(UTC).isoformat(timespec="milliseconds")
    described.started = datetime.fromisoformat(first.started)
    described.checkpoints = first.checkpoints
    described.resumed = (
        *first.resumed,
        Resumption(tick=tick, started=now),
    )
    notes = surroundings(first, described.manifest(RUNNING, 0, folder))
    report, interruption = run_into(
        described,
        folder,
        progress(described.experiment),
        None,
        first.checkpoints.log,
        page=first.checkpoints.page,
        goes_on=True,
    )
    return Resumed(report, interruption, tick, notes)

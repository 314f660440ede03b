"""A run repeated from its folder: the same bits, or what differs."""

from __future__ import annotations

import tempfile
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from master.api import prepare_to_run
from master.catalogue import Progress, silent
from master.errors import ConfigError, DataError, Problem
from master.evaluation.report import Report
from master.experiment.experiment import Experiment
from master.installation import configuration
from master.recording.folder import MANIFEST

from .differences import Comparison, compare_runs
from .execute import Shown, run_into
from .hashes import sha256
from .manifest import Described, HashedFile, Ingredients, Manifest, read_manifest, result_hashes
from .run_data import read_run


@dataclass(frozen=True)
class Repeated:
    """
    What a repeated run came to.

    `changed` are inputs and results that are not those of the first run, `surroundings` what else differs
    (version, commit, machine), a line each; `comparison` is None where one of the runs has no rows,
    `interrupted_by` the signal that ended the second one.
    """

    first: Manifest
    report: Report
    changed: list[str]
    surroundings: list[str]
    comparison: Comparison | None
    interrupted_by: int | None = None

    @property
    def faults(self) -> list[str]:
        """All that makes it another run than the first, a line each."""
        first, again = self.first, self.report
        faults = [*self.changed]
        if (first.status, first.steps) != (again.status, again.steps):
            got = f"{again.status} after {again.steps} steps"
            faults.append(f"end: got {got}, expected {first.status} after {first.steps} steps")
        if self.comparison is None:
            return [*faults, "results: one of the runs has no rows, expected rows in both"]
        return faults + self.comparison.faults

    @property
    def is_same(self) -> bool:
        """Whether inputs, end and bits are those of the first run."""
        return not self.faults

    def as_dict(self) -> dict[str, Any]:
        """Return everything for JSON."""
        return {
            "same": self.is_same,
            "differences": self.faults,
            "surroundings": self.surroundings,
            "status": self.report.status,
            "comparison": None if self.comparison is None else self.comparison.as_dict(),
        }


def repeat(
    folder: Path,
    output: Path | None,
    progress: Callable[[Experiment], Shown],
    building: Progress = silent,
) -> Repeated:
    """
    Repeat the run of a results folder and compare both.

    Args:
        folder: Results of the first run, with its manifest.
        output: Folder for the results of the second; None for one that is removed afterwards.
        progress: Returns for a system what begins to show progress.
        building: Told what is built.

    Raises:
        ConfigError: If the configuration is gone or wrong, with what of it has changed.
        DataError: If the manifest or a result file cannot be read.
        FmuError: If an FMU cannot be loaded or initialised.
    """
    first = read_manifest(folder)
    if output is not None and output.resolve() == folder.resolve():
        expected = "a folder of its own: the first results are needed"
        raise DataError(f"--output: would replace what is compared, got {output}, expected {expected}")
    if output is not None:
        return _repeated(first, folder, output, progress, building)
    with tempfile.TemporaryDirectory(prefix="dockloop-") as place:
        return _repeated(first, folder, Path(place), progress, building)


def _repeated(
    first: Manifest,
    folder: Path,
    output: Path,
    progress: Callable[[Experiment], Shown],
    building: Progress,
) -> Repeated:
    described = described_again(first, building)
    experiment = described.experiment
    changed = changed_inputs(first, described.look()) + _changed_results(first, folder)
    report, interruption = run_into(described, output, progress(experiment))
    again = described.manifest(report.status, report.steps, output)
    has_rows = bool(first.results and again.results)
    comparison = compare_runs(read_run(folder), read_run(output)) if has_rows else None
    return Repeated(first, report, changed, surroundings(first, again), comparison, interruption.number)


def described_again(first: Manifest, building: Progress = silent) -> Described:
    """
    Prepare what a manifest describes.

    Raises:
        ConfigError: If the configuration is gone or wrong, with what of it has changed.
        FmuError: If an FMU fails while a phase lead is designed.
    """
    path = _configuration(first)
    request = first.asked.request()
    try:
        experiment = prepare_to_run(path, request, building)
    except ConfigError as error:
        if not path.is_file() or sha256(path) == first.configuration.sha256:
            raise
        said = Problem("has changed since the first run", where=str(path))
        raise ConfigError([said, *error.problems]) from None
    return Described(first.given, path, request, experiment)


def _configuration(first: Manifest) -> Path:
    """Find the configuration where it was, else as it was named."""
    path = Path(first.configuration.path or "")
    return path if path.is_file() else configuration(first.given)


def changed_inputs(first: Manifest, now: Ingredients) -> list[str]:
    """Name each file and seed of a run that differs from the first run's, a line each."""
    lines = _changed("configuration", first.configuration, now.configuration)
    for kind, before, after in (("fmus", first.fmus, now.fmus), ("inputs", first.inputs, now.inputs)):
        for name in {**before, **after}:
            lines += _changed(f"{kind}.{name}", before.get(name), after.get(name))
    for name in {**first.seeds, **now.seeds}:
        before_, after_ = first.seeds.get(name), now.seeds.get(name)
        if before_ != after_:
            lines.append(f"seeds.{name}: got {after_}, expected {before_}")
    return lines


def _changed(where: str, before: HashedFile | None, after: HashedFile | None) -> list[str]:
    if before is None or after is None:
        return [f"{where}: is {'new' if before is None else 'gone'}, expected the files of the first run"]
    file = f" ({after.path})" if after.path else ""
    if before.sha256 is None or after.sha256 is None:
        run = "first" if before.sha256 is None else "second"
        return [f"{where}: could not be read in the {run} run{file}, expected a file with a known hash"]
    if before.sha256 == after.sha256:
        return []
    return [f"{where}: has changed{file}, got sha256 {after.sha256[:12]}, expected {before.sha256[:12]}"]


def _changed_results(first: Manifest, folder: Path) -> list[str]:
    """Files of the first run that are not as it left them."""
    now = result_hashes(folder)
    lines = []
    for name in {**first.results, **now}:
        if first.results.get(name) != now.get(name):
            lines.append(f"{folder / name}: is not what the run wrote, expected the file of its {MANIFEST}")
    return lines


def surroundings(first: Manifest, again: Manifest) -> list[str]:
    """Name what else differs: version, commit, machine, packages; a line each."""
    before = {**first.dockloop, **first.machine}
    after = {**again.dockloop, **again.machine}
    return [
        f"{key}: got {after.get(key)}, in the first run {before.get(key)}"
        for key in {**before, **after}
        if before.get(key) != after.get(key)
    ]

"""Before and after on the sealed rows, read once, by running the FMUs that are handed over."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from master import catalogue
from master.diagnosis.case.cut import CutPart, CutSystem
from master.diagnosis.case.split import Stretch
from master.diagnosis.judge.diagnose import Diagnosis
from master.diagnosis.judge.part_result import PartResult
from master.diagnosis.numerics.arrays import Array
from master.diagnosis.numerics.error_measures import Errors, errors
from master.diagnosis.replay.candidate_models import links
from master.diagnosis.replay.replay_bench import ReplayBench
from master.diagnosis.replay.replayer import Player
from master.diagnosis.search.study import merged


@dataclass(frozen=True)
class SealedPart:
    """Sealed rows of one part: time [s], shape (rows,), the others (rows, outputs)."""

    part: CutPart
    t: Array
    measured: Array
    before: Array
    after: Array
    nominal: Array

    def errors_of(self, predicted: Array) -> dict[str, Errors]:
        """Errors of one of the predictions, by signal."""
        return {
            name: errors(self.measured[:, i], predicted[:, i]) for i, name in enumerate(self.part.compared)
        }

    @property
    def explained_share(self) -> float:
        """Share of the sealed residual power, each output scaled by its own, that the effect takes away."""
        before = np.mean((self.before - self.measured) ** 2, axis=0)
        after = np.mean((self.after - self.measured) ** 2, axis=0)
        used = before > 0.0
        return float(np.mean(1.0 - after[used] / before[used])) if used.any() else 0.0


def sealed(diagnosis: Diagnosis, files: Mapping[str, Path]) -> dict[str, SealedPart]:
    """
    Break the seal and run every part, before and after.

    Args:
        diagnosis: What was found on the other rows.
        files: FMU to the file that is handed over; the others are unchanged.

    Returns:
        By the name of the part.
    """
    stretches = diagnosis.split.sealed.open()
    return {part.name: _one(diagnosis, part, files, stretches) for part in diagnosis.parts}


def _one(
    diagnosis: Diagnosis, result: PartResult, files: Mapping[str, Path], stretches: Sequence[Stretch]
) -> SealedPart:
    system = diagnosis.system
    bench = _bench(diagnosis, result, {s.recording for s in stretches})
    rows = np.concatenate([np.arange(s.begin, s.end) + bench.begin(s.recording) for s in stretches])
    rows = rows[rows < len(bench.measured)]
    rows = rows[bench.in_use[rows]]
    old = _files(system, bench.part)
    before = _run(bench, system, old, result.base.values)
    nominal = _run(bench, system, old, {})
    after = before
    if result.has_effect:
        new = {fmu: files.get(fmu, file) for fmu, file in old.items()}
        after = _run(bench, system, new, result.values)
    return SealedPart(
        part=bench.part,
        t=rows * bench.row_period,
        measured=bench.measured[rows],
        before=before[rows],
        after=after[rows],
        nominal=nominal[rows],
    )


def _bench(diagnosis: Diagnosis, result: PartResult, names: set[str]) -> ReplayBench:
    """The bench of the study, or one with the recordings that are sealed as a whole."""
    bench = result.study.bench
    recordings = {name: r for name, r in diagnosis.recordings.items() if name in names}
    if set(recordings) <= set(bench.lengths):
        return bench
    fitted = bench.fitted & set(recordings)
    return ReplayBench(bench.part, recordings, diagnosis.loaded.case, fitted)


def _files(system: CutSystem, part: CutPart) -> dict[str, Path]:
    targets = {f: catalogue.locate(system.sources[f], system.folder, "native") for f in part.fmus}
    return catalogue.files(targets, catalogue.silent)


def _run(
    bench: ReplayBench, system: CutSystem, files: Mapping[str, Path], values: Mapping[str, float]
) -> Array:
    with closing(Player(links(system, bench.part, files))) as player:
        return bench.predict(player, merged(system.values, values))

"""Before and after on the sealed rows, read once, by running the FMUs that are handed over."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from master import catalogue
from master.diagnosis.case.cut import CutSystem, Part
from master.diagnosis.case.split import Stretch
from master.diagnosis.judge.diagnose import Diagnosis
from master.diagnosis.judge.part_result import PartResult
from master.diagnosis.numerics.arrays import Array
from master.diagnosis.numerics.whiteness import block_bootstrap, correlation_length
from master.diagnosis.replay.candidate_models import links
from master.diagnosis.replay.replay import Bench
from master.diagnosis.replay.replayer import Player
from master.diagnosis.search.study import merged

N_DRAWS = 300


@dataclass(frozen=True)
class SealedPart:
    """Sealed rows of one part: time [s], shape (rows,), the others (rows, outputs)."""

    part: Part
    t: Array
    measured: Array
    before: Array
    after: Array
    nominal: Array

    def table(self, which: str) -> dict[str, dict[str, Any]]:
        """Errors by signal."""
        predicted: Array = getattr(self, which)
        return {
            name: _errors(self.measured[:, i], predicted[:, i]) for i, name in enumerate(self.part.compared)
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
    """
    stretches = diagnosis.split.sealed.open()
    return {p.study.bench.part.name: _one(diagnosis, p, files, stretches) for p in diagnosis.parts}


def _one(
    diagnosis: Diagnosis, result: PartResult, files: Mapping[str, Path], stretches: tuple[Stretch, ...]
) -> SealedPart:
    bench, system = result.study.bench, diagnosis.system
    own = {n: r for n, r in diagnosis.recordings.items() if n in {s.recording for s in stretches}}
    if not set(own) <= set(bench.lengths):
        fitted = bench.fitted & set(own)
        bench = Bench(bench.part, own, diagnosis.loaded.case)
        bench.fitted = fitted
    rows = np.concatenate(
        [np.arange(bench.begin(s.recording) + s.begin, bench.begin(s.recording) + s.end) for s in stretches]
    )
    rows = rows[(rows < len(bench.measured))]
    rows = rows[bench.in_use[rows]]
    old = _files(system, bench.part)
    before = _run(bench, system, old, result.base.values)
    nominal = _run(bench, system, old, {})
    after = before
    if result.has_effect:
        values = dict(result.chosen.fixed) | dict(result.fit.values)
        after = _run(bench, system, {**old, **{k: f for k, f in files.items() if k in old}}, values)
    t = rows * bench.row_period
    return SealedPart(bench.part, t, bench.measured[rows], before[rows], after[rows], nominal[rows])


def _files(system: CutSystem, part: Part) -> dict[str, Path]:
    targets = {f: catalogue.locate(system.sources[f], system.folder, "native") for f in part.fmus}
    return catalogue.files(targets, catalogue.silent)


def _run(bench: Bench, system: CutSystem, files: Mapping[str, Path], values: Mapping[str, float]) -> Array:
    player = Player(links(system, bench.part, files))
    try:
        return bench.predict(player, merged(system.values, values))
    finally:
        player.close()


def _errors(measured: Array, predicted: Array) -> dict[str, Any]:
    left = predicted - measured
    size = float(np.sqrt(np.mean(measured**2))) or 1.0
    if not np.isfinite(left).all():
        return {"rmse": None, "nrmse_percent": None, "max": None, "energy": None, "rmse_interval": None}
    block = correlation_length(left)
    low, high = block_bootstrap(_rms, left, block=block, n_draws=N_DRAWS)
    return {
        "rmse": _rms(left),
        "nrmse_percent": 100.0 * _rms(left) / size,
        "max": float(np.abs(left).max()),
        "energy": float(np.sum(predicted**2) / max(np.sum(measured**2), 1e-300)),
        "rmse_interval": [low, high],
    }


def _rms(values: Array) -> float:
    return float(np.sqrt(np.mean(values**2)))

"""Before and after on the sealed rows, read once, by running the FMUs that are handed over."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from contextlib import closing
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import NamedTuple

import numpy as np

from master import catalogue
from master.diagnosis.case.cut import CutPart, CutSystem
from master.diagnosis.case.split import Stretch
from master.diagnosis.judge.diagnose import Diagnosis
from master.diagnosis.judge.part_result import PartResult
from master.diagnosis.numerics.arrays import Array, Integers
from master.diagnosis.numerics.error_measures import Errors, errors
from master.diagnosis.numerics.sealed_gain import SealedGain, sealed_gain
from master.diagnosis.replay.candidate_models import links
from master.diagnosis.replay.replay_bench import Estimated, ReplayBench, Segment
from master.diagnosis.replay.replayer import Player
from master.diagnosis.search.study import merged


@dataclass(frozen=True)
class SealedPart:
    """
    Sealed rows of one part: time [s], shape (rows,), the others (rows, outputs).

    `gains` is what each effect takes away by itself, `rivals` is the rms that every
    fitted effect leaves, by signal, `gain` what all take over the refit and over the
    nominal model. `failure` says why a replay ended early, None if none did. `estimates` are what was
    estimated on rows of these recordings, by segment; of a whole recording, those rows are left out here.
    """

    part: CutPart
    t: Array
    measured: Array
    before: Array
    after: Array
    nominal: Array
    gains: Mapping[str, SealedGain | None] = field(default_factory=dict)
    rivals: Mapping[str, Mapping[str, float]] = field(default_factory=dict)
    failure: str | None = None
    estimates: Mapping[Segment, Estimated] = field(default_factory=dict)

    @property
    def gain(self) -> SealedGain | None:
        """What the effects take away of what the refit leaves."""
        return sealed_gain(self.measured, self.before, self.after, self.scale)

    @property
    def gain_over_nominal(self) -> SealedGain | None:
        """What the effects take away of what the nominal model leaves."""
        return sealed_gain(self.measured, self.nominal, self.after, self.scale)

    @property
    def is_confirmed(self) -> bool:
        """Whether the model with effects is better than refit and nominal model, beyond chance."""
        gains = (self.gain, self.gain_over_nominal)
        return all(g is not None and g.interval.low > 0.0 for g in gains)

    @property
    def is_refit_worse(self) -> bool:
        """Whether the nominal model is better than the refit, beyond chance."""
        gain = sealed_gain(self.measured, self.before, self.nominal, self.scale)
        return gain is not None and gain.interval.low > 0.0

    @property
    def scale(self) -> Array:
        """Scale of each output: what the refit leaves, shape (outputs,)."""
        size = np.sqrt(np.mean((self.before - self.measured) ** 2, axis=0))
        return np.where(np.isfinite(size) & (size > 0.0), size, 1.0)

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
    old = _files(system, bench.part)
    before = _run(bench, system, old, result.base.values)
    nominal = _run(bench, system, old, {})
    after = before
    if result.has_effect:
        new = {fmu: files.get(fmu, file) for fmu, file in old.items()}
        after = _run(bench, system, new, result.values)
    rows = np.concatenate([np.arange(s.begin, s.end) + bench.begin(s.recording) for s in stretches])
    rows = rows[rows < len(bench.measured)]
    rows = rows[bench.in_use[rows]]
    unseen = rows[~bench.looked_at()[rows]]
    estimates = dict(bench.estimates)
    if len(unseen):
        rows = unseen
    else:  # a short sealed block at the beginning: better to score it, and to say so, than nothing
        estimates = {s: replace(e, rows=len(s)) for s, e in estimates.items()}
    measured = bench.measured[rows]
    own = SealedPart(
        part=bench.part,
        t=rows * bench.row_period,
        measured=measured,
        before=before.predicted[rows],
        after=after.predicted[rows],
        nominal=nominal.predicted[rows],
        failure=next((r.failure for r in (after, before, nominal) if r.failure), None),
        estimates=estimates,
    )
    gains = {}
    for name, less in result.without.items():
        without = own.before
        if less.model.effects:
            values = dict(less.model.fixed) | dict(less.fit.values)
            player = result.study.pool.player(less.model.effects)
            without = bench.predict(player, merged(system.values, values))[rows]
        gains[name] = sealed_gain(measured, without, own.after, own.scale)
    return replace(own, gains=gains, rivals=_rivals(result, bench, rows, own.part.compared))


def _rivals(
    result: PartResult, bench: ReplayBench, rows: Integers, signals: Iterable[str]
) -> dict[str, dict[str, float]]:
    """Sealed rms that each fitted effect leaves in the model of its round, by effect and signal."""
    found: dict[str, dict[str, float]] = {}
    for step in () if result.search is None else result.search.rounds:
        for r in step.ranked:
            values = dict(r.model.fixed) | dict(r.gain.fit.values)
            player = result.study.pool.player(r.model.effects)
            predicted = bench.predict(player, merged(result.study.system.values, values))[rows]
            left = np.sqrt(np.mean((predicted - bench.measured[rows]) ** 2, axis=0))
            if np.isfinite(left).all():
                found[r.name] = dict(zip(signals, left.tolist(), strict=True))
    return found


def _bench(diagnosis: Diagnosis, result: PartResult, names: set[str]) -> ReplayBench:
    """The bench of the study, or one with the recordings that are sealed as a whole."""
    bench = result.study.bench
    recordings = {name: r for name, r in diagnosis.recordings.items() if name in names}
    if set(recordings) <= set(bench.lengths):
        return bench.afresh()
    fitted = bench.fitted & set(recordings)
    return ReplayBench(bench.part, recordings, diagnosis.loaded.case, fitted)


def _files(system: CutSystem, part: CutPart) -> dict[str, Path]:
    targets = {f: catalogue.locate(system.sources[f], system.folder, "native") for f in part.fmus}
    return catalogue.files(targets, catalogue.silent)


class Run(NamedTuple):
    """Prediction of all rows (rows, outputs), and why it ended early if it did."""

    predicted: Array
    failure: str | None


def _run(
    bench: ReplayBench, system: CutSystem, files: Mapping[str, Path], values: Mapping[str, float]
) -> Run:
    given = merged(system.values, values)
    with closing(Player(links(system, bench.part, files))) as player:
        predicted = bench.predict(player, given)
        if np.isfinite(predicted[bench.in_use]).all():
            return Run(predicted, None)
        failure = bench.failure(player, given)
        return Run(predicted, str(failure or "the replay is not finite"))

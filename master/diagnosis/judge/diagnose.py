"""From a case to what each part lacks: localise, refit, detect, ceiling, rank, name or learn."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from master.diagnosis.case.case import Case, LoadedCase
from master.diagnosis.case.cut import CutSystem, Part
from master.diagnosis.case.split import (
    Split,
    Stretch,
    blocks,
    by_blocks,
    by_recording,
    with_sealed_recordings,
)
from master.diagnosis.data.measured_signals import opened
from master.diagnosis.data.recordings import Recording
from master.diagnosis.numerics.gains import ERRORS, gain, powers
from master.diagnosis.numerics.least_squares import Mask
from master.diagnosis.replay.candidate_models import Pool, candidates
from master.diagnosis.replay.replay import Bench
from master.diagnosis.search.rounds import search
from master.diagnosis.search.simplify import with_rewritings
from master.diagnosis.search.study import Extended, Progress, Study, base_parameters, start
from master.errors import ConfigError, DataError

from .evidence import detect
from .named_or_learned import named_or_learned
from .part_result import PartResult
from .plausible import implausible
from .refit import refitted

N_BLOCKS = 12
MOVED = 3.0


@dataclass(frozen=True)
class Diagnosis:
    """All parts of a case, before the sealed rows are read."""

    loaded: LoadedCase
    system: CutSystem
    recordings: Mapping[str, Recording]
    parts: tuple[PartResult, ...]
    split: Split

    @property
    def main(self) -> PartResult:
        """The part with the effect that explains most of its residual; the first where there is none."""

        def share(p: PartResult) -> float:
            rows = p.study.fit_rows
            left = [
                np.nanmean(((f.predicted - p.study.measured) / p.study.size)[rows] ** 2)
                for f in (p.base, p.fit)
            ]
            return float(np.log(left[0] / left[1])) if p.has_effect else -1.0

        return max(self.parts, key=share)

    def close(self) -> None:
        """Unload all FMUs."""
        for part in self.parts:
            part.study.pool.close()


def diagnose(loaded: LoadedCase, progress: Progress) -> Diagnosis:
    """
    Study all parts of a case on the rows to fit on and to select by.

    Raises:
        ConfigError: If the case, its system or its recordings are wrong.
    """
    system, recordings = opened(loaded, progress)
    benches = {part.name: _bench(part, recordings, loaded.case) for part in system.parts}
    some = next(iter(benches.values()))
    split = _split(loaded, _lengths(some, recordings), some.row_period)
    begun = [_begun(system, benches[part.name], split, loaded.case, progress) for part in system.parts]
    problems = implausible(loaded, begun)
    if problems:
        for part in begun:
            part.study.pool.close()
        raise ConfigError(problems)
    results = tuple(_searched(p, system, loaded.case) for p in begun)
    return Diagnosis(loaded, system, recordings, results, split)


def _bench(part: Part, recordings: Mapping[str, Recording], case: Case) -> Bench:
    """Rows of whole sealed recordings are not on the bench."""
    open_ones = {n: r for n, r in recordings.items() if n not in case.split.sealed}
    return Bench(part, open_ones, case)


def _lengths(bench: Bench, recordings: Mapping[str, Recording]) -> dict[str, int]:
    options = bench.options
    return {n: -(-(len(r) - 2 * options.cut) // options.decimate) for n, r in recordings.items()}


def _split(loaded: LoadedCase, lengths: Mapping[str, int], period: float) -> Split:
    entry = loaded.case.split
    try:
        if entry.blocks is None:
            return by_recording(lengths, {"fit": entry.fit, "select": entry.select, "sealed": entry.sealed})
        guard = round(entry.guard / period)
        if entry.sealed:
            return with_sealed_recordings(lengths, entry.blocks, guard, entry.sealed)
        return by_blocks(lengths, entry.blocks, guard)
    except DataError as error:
        raise ConfigError(f"{loaded.where('split')}: {line}" for line in str(error).splitlines()) from None


def _begun(system: CutSystem, bench: Bench, split: Split, case: Case, progress: Progress) -> PartResult:
    """Replay and refit one part."""
    part, pool = bench.part, Pool(system, bench.part)
    rows = bench.in_use & _rows(bench, split.fit)
    held_out = [_slice(bench, s) for s in blocks(split.select, N_BLOCKS)]
    held_out = [s for s in held_out if bench.in_use[s].all()]
    study = Study(system, bench, pool, base_parameters(case, system, part.fmus), rows, held_out, progress)
    progress(f"{part.name}: replay and refit")
    bench.fitted = {s.recording for s in split.fit}
    nominal = study.simulate((), {}, everything=True)
    base = start(study)
    empty = PartResult(study, nominal, base, Extended(), base)
    return replace(empty, is_exact=study.is_exact(study.size))


def _searched(begun: PartResult, system: CutSystem, case: Case) -> PartResult:
    """What one part lacks, if anything is left of it."""
    if begun.is_exact:
        return begun
    study, base = begun.study, begun.base
    study.look_into_slots(base)
    wanted = candidates(system, study.bench.part, case.slots)
    result = detect(begun)
    if wanted:
        slots = sorted({f"{a.fmu}.{a.slot}" for a in wanted})
        found = with_rewritings(study, search(study, base, wanted), wanted)
        result = named_or_learned(result, found, slots)
    elif result.ceiling is not None and result.ceiling.is_structure:
        result = replace(result, has_remainder=True)
    return refitted(_parameters(result))


def _parameters(result: PartResult) -> PartResult:
    """Which parameters moved from their values, and whether that pays on held-out rows."""
    study, fit = result.study, result.fit
    moved = {
        p.name: fit.values[p.name] - p.start
        for p in study.base
        if abs(fit.values[p.name] - p.start) > MOVED * max(fit.deviations[p.name], 1e-12 * p.scale)
    }
    before = powers(result.nominal - study.measured, study.held_out, study.size)
    own = powers(result.base.predicted - study.measured, study.held_out, study.size)
    found = gain(result.base, before, own)
    pays = found.mean > 0.01 and found.mean > ERRORS * found.error
    return replace(result, moved=moved, parameter_gain=bool(moved) and pays)


def _rows(bench: Bench, stretches: tuple[Stretch, ...]) -> Mask:
    rows = np.zeros(len(bench.measured), dtype=bool)
    for s in stretches:
        if s.recording in bench.lengths:
            rows[_slice(bench, s)] = True
    return rows


def _slice(bench: Bench, s: Stretch) -> slice:
    at = bench.begin(s.recording)
    return slice(at + s.begin, at + min(s.end, bench.lengths[s.recording]))

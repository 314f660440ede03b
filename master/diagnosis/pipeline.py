"""From a case to what each part lacks: localise, refit, detect, ceiling, rank, name or learn."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from ..errors import ConfigError, DataError
from .bench import Bench
from .case import Case, LoadedCase
from .ceiling import Ceiling
from .evidence import ceiling_of, detect, features_of, worst_output
from .final import refitted
from .fitting import Fit, Mask
from .learning import Learned, learn
from .measured import opened
from .part_result import EXACT, PartResult
from .parts import CutSystem, Part
from .ranking import ERRORS, gain, powers
from .recordings import Recording
from .search import Found, is_accepted, is_worse, search
from .split import Split, Stretch, blocks, by_blocks, by_recording, with_sealed_recordings
from .study import Extended, Progress, Study, base_parameters, start
from .tables import Array
from .variants import Pool, candidates

N_BLOCKS = 12
SMALL_REMAINDER, NAMED_SHARE = 0.05, 0.8
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
    results = [_part(system, benches[part.name], split, loaded.case, progress) for part in system.parts]
    return Diagnosis(loaded, system, recordings, tuple(results), split)


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


def _part(system: CutSystem, bench: Bench, split: Split, case: Case, progress: Progress) -> PartResult:
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
    spread = study.measured[rows].std(axis=0)
    if np.all(study.size < EXACT * np.maximum(spread, 1e-300)):
        return replace(empty, is_exact=True)
    wanted = candidates(system, part, case.slots)
    result = detect(empty)
    if wanted:
        result = _named_or_learned(
            result, search(study, base, wanted), sorted({f"{a.fmu}.{a.slot}" for a in wanted})
        )
    elif result.ceiling is not None and result.ceiling.is_structure:
        result = replace(result, has_remainder=True)
    return refitted(_parameters(result))


def _named_or_learned(result: PartResult, found: Found, slots: list[str]) -> PartResult:
    """Keep the names, or find that a law without a name explains it better."""
    study = result.study
    result = replace(result, found=found, chosen=found.extended, fit=found.fit)
    if not found.extended.added and not _suspicious(result):
        return result
    crowded = _crowded(found)
    if crowded:
        alone = learn(study, Extended(), found.base, crowded)
        named = gain(found.fit, *_powers(study, found.base, found.fit))
        if alone is not None and is_accepted(alone.gain, 5) and not is_worse(alone.gain, named):
            return _undeclared(result, alone)
    left = study.measured - found.fit.predicted
    after = ceiling_of(study, left[:, worst_output(study)], features_of(study))
    if after is not None and after.is_structure:
        found = found.widened(study)
    result = replace(result, found=found, ceiling_after=after)
    if found.extended.added and _is_small(result, after):
        return result
    law = learn(study, found.extended, found.fit, slots)
    if law is None or not is_accepted(law.gain, 5):
        return result
    if not found.extended.added:
        return _undeclared(result, law)
    return _against_names(result, found, law, slots)


def _crowded(found: Found) -> list[str]:
    """Slots with more than one effect: one law without a name may be behind them."""
    slots = [f"{a.fmu}.{a.slot}" for a in found.extended.added]
    return sorted({s for s in slots if slots.count(s) > 1})


def _is_small(result: PartResult, after: Ceiling | None) -> bool:
    """Whether what any law could still explain is little beside what the names explain."""
    if after is None or not after.is_structure:
        return True
    before, named = (float(p.mean()) for p in _powers(result.study, result.base, result.fit))
    return after.share * named < SMALL_REMAINDER * (before - named)


def _against_names(result: PartResult, found: Found, law: Learned, slots: list[str]) -> PartResult:
    """Names stay if they explain most and a law without a name does not do better alone."""
    study = result.study
    power = {
        name: float(np.mean(powers(f.predicted - study.measured, study.held_out, study.size)))
        for name, f in (("base", found.base), ("named", found.fit), ("both", law.fit))
    }
    explained, remainder = power["base"] - power["named"], power["named"] - power["both"]
    if remainder < SMALL_REMAINDER * explained:
        return result
    named = gain(found.fit, *_powers(study, found.base, found.fit))
    alone = learn(study, Extended(), found.base, slots)
    is_better = alone is not None and is_accepted(alone.gain, 5) and is_worse(named, alone.gain)
    if alone is not None and (is_better or explained < NAMED_SHARE * (explained + remainder)):
        return _undeclared(result, alone)
    return replace(result, has_remainder=True, learned=law, chosen=law.extended, fit=law.fit)


def _powers(study: Study, *fits: Fit) -> list[Array]:
    return [powers(f.predicted - study.measured, study.held_out, study.size) for f in fits]


def _undeclared(result: PartResult, law: Learned) -> PartResult:
    return replace(result, learned=law, chosen=law.extended, fit=law.fit, is_named=False)


def _suspicious(result: PartResult) -> bool:
    """Whether the residual of the base looks as if something was missing."""
    has_ceiling = result.ceiling is not None and result.ceiling.is_structure
    return has_ceiling or any(not d.is_constant for d in result.drifts)


def _parameters(result: PartResult) -> PartResult:
    """Which parameters moved from their values, and whether that pays on held-out rows."""
    study, fit = result.study, result.fit
    moved = {
        p.name: fit.values[p.name] - p.start
        for p in study.base
        if abs(fit.values[p.name] - p.start) > MOVED * max(fit.deviations[p.name], 1e-12 * p.scale)
    }
    before = powers(result.nominal - study.measured, study.held_out, study.size)
    found = gain(result.base, before, _powers(study, result.base)[0])
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

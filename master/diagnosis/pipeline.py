"""From a case to what each part lacks: localise, refit, detect, ceiling, rank, name or learn."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

import numpy as np

from ..errors import ConfigError, DataError
from .bench import Bench
from .case import Case, LoadedCase
from .ceiling import Ceiling, ceiling, history
from .drift import Drift, drift
from .fitting import Fit, Mask
from .learning import Learned, learn
from .measured import measured
from .part_result import EXACT, PartResult
from .parts import CutSystem, Part, cut
from .ranking import ERRORS, gain, powers
from .recordings import Recording
from .screening import Tangent
from .search import Found, is_accepted, is_worse, search
from .split import Split, Stretch, blocks, by_blocks, by_recording, with_sealed_recordings
from .statistics import cross_correlations, ljung_box
from .study import Extended, Progress, Study, base_parameters, start
from .tables import Array
from .variants import Pool, candidates

N_BLOCKS, N_GROUPS = 12, 8
LAGS = (0.01, 0.03, 0.1)
SMALL_REMAINDER, NAMED_SHARE = 0.05, 0.8
MOVED = 3.0
SHAPES: dict[str, Callable[[Array], Array]] = {
    "abs": np.abs,
    "squared": lambda f: f * f,
    "cubed": lambda f: f * f * f,
    "sign": np.sign,
}


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
    system, recordings = cut(loaded, progress), measured(loaded)
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
    nominal = study.simulate((), {})
    base = start(study)
    empty = PartResult(study, nominal, base, Extended(), base)
    spread = study.measured[rows].std(axis=0)
    if np.all(study.size < EXACT * np.maximum(spread, 1e-300)):
        return replace(empty, is_exact=True)
    wanted = candidates(system, part, case.slots)
    result = _detect(empty)
    if wanted:
        result = _named_or_learned(
            result, search(study, base, wanted), sorted({f"{a.fmu}.{a.slot}" for a in wanted})
        )
    elif result.ceiling is not None and result.ceiling.is_structure:
        result = replace(result, has_remainder=True)
    return _parameters(result)


def _detect(result: PartResult) -> PartResult:
    """Tests on the residual of the base; they are reported."""
    study = result.study
    study.progress(f"{study.bench.part.name}: tests on the residual")
    left = study.measured - result.base.predicted
    worst = int(np.argmax(study.size / np.maximum(study.measured.std(axis=0), 1e-300)))
    rows = study.bench.in_use
    features = _features(study)
    bases = {
        f"{name} {what}": values[rows]
        for name, f in features.items()
        for what, values in (
            ("abs", np.abs(f)),
            ("squared", f * f),
            ("cubed", f * f * f),
            ("sign", np.sign(f)),
        )
        if np.ptp(f) > 0.0 and np.ptp(values[rows]) > 0.0
    }
    linear = {name: f[rows] for name, f in features.items() if np.ptp(f) > 0.0}
    found = cross_correlations(left[rows, worst], bases, linear=linear) if bases else []
    return replace(
        result,
        correlations=tuple(found[:10]),
        whiteness=ljung_box(left[rows, worst]),
        ceiling=_ceiling(study, left[:, worst], features),
        drifts=_drifts(study, Extended(), result.base),
    )


def _named_or_learned(result: PartResult, found: Found, slots: list[str]) -> PartResult:
    """Keep the names, or find that a law without a name explains it better."""
    study = result.study
    result = replace(result, found=found, chosen=found.extended, fit=found.fit)
    if not found.extended.added and not _suspicious(result):
        return result
    left = study.measured - found.fit.predicted
    worst = int(np.argmax(study.size / np.maximum(study.measured.std(axis=0), 1e-300)))
    after = _ceiling(study, left[:, worst], _features(study))
    result = replace(result, ceiling_after=after)
    if found.extended.added and _is_small(result, after):
        return result
    law = learn(study, found.extended, found.fit, slots)
    if law is None or not is_accepted(law.gain, 5):
        return result
    if not found.extended.added:
        return _undeclared(result, law)
    return _against_names(result, found, law, slots)


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


def _features(study: Study) -> dict[str, Array]:
    found: dict[str, Array] = {}
    for slot, signals in study.signals.items():
        for role, values in signals.items():
            rows = study.bench.compared_rows(values)
            if np.ptp(rows) > 0.0 and not any(_alike(rows, other) for other in found.values()):
                found[f"{slot} {role}"] = rows
    return found


def _alike(a: Array, b: Array) -> bool:
    return bool(abs(np.corrcoef(a, b)[0, 1]) > 0.9999)


def _ceiling(study: Study, left: Array, features: Mapping[str, Array]) -> Ceiling | None:
    if not features:
        return None
    lags = [max(1, round(lag / study.bench.row_period)) for lag in LAGS]
    use = study.bench.in_use & (study.fit_rows | _any(study))
    n = int(use.sum())
    edges = [n * i // N_GROUPS for i in range(N_GROUPS + 1)]
    parts = [slice(a, b) for a, b in itertools.pairwise(edges)]
    guard = round(0.1 / study.bench.row_period)
    return ceiling(left[use], history(features, lags)[use], parts, guard=guard)


def _any(study: Study) -> Mask:
    rows = np.zeros(len(study.measured), dtype=bool)
    for block in study.held_out:
        rows[block] = True
    return rows


def _drifts(study: Study, chosen: Extended, found: Fit) -> tuple[Drift, ...]:
    """Parameters fitted on groups of rows alone, by one linear step."""
    tangent = Tangent(study, chosen, found)
    if not tangent.columns:
        return ()
    rows = np.flatnonzero(study.fit_rows)
    k = study.measured.shape[1]
    values, deviations, times, amplitudes = [], [], [], []
    for group in np.array_split(np.arange(len(rows)), N_GROUPS):
        index = (group[:, None] * k + np.arange(k)).ravel()
        a = np.column_stack([c[index] for c in tangent.columns])
        r = tangent.residual[index]
        normal = np.linalg.pinv(a.T @ a + tangent.prior.T @ tangent.prior)
        step = normal @ (a.T @ r)
        values.append(step)
        deviations.append(
            np.sqrt(np.maximum(np.diag(normal), 1e-300) * float(np.mean(r * r)) * _inflation(r))
        )
        times.append(float(rows[group].mean()) * study.bench.row_period)
        amplitudes.append(float(study.measured[rows[group], 0].std()))
    covariates = {"time": np.array(times), "amplitude": np.array(amplitudes)}
    return tuple(
        drift(p.name, found.values[p.name] + np.array(values)[:, i], np.array(deviations)[:, i], covariates)
        for i, p in enumerate(tangent.fitted)
    )


def _inflation(residual: Array, longest: int = 200) -> float:
    """Variance factor of means of a coloured residual."""
    e = residual - residual.mean()
    n, power = len(e), float(e @ e) or 1.0
    total = 1.0
    for lag in range(1, min(longest, n // 4)):
        r = float(e[lag:] @ e[: n - lag]) / power
        if r < 0.05:
            break
        total += 2.0 * r
    return total


def _rows(bench: Bench, stretches: tuple[Stretch, ...]) -> Mask:
    rows = np.zeros(len(bench.measured), dtype=bool)
    for s in stretches:
        if s.recording in bench.lengths:
            rows[_slice(bench, s)] = True
    return rows


def _slice(bench: Bench, s: Stretch) -> slice:
    at = bench.begin(s.recording)
    return slice(at + s.begin, at + min(s.end, bench.lengths[s.recording]))

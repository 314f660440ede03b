"""Evidence in the residual of the base: correlations, ceiling, parameters that drift. It is reported."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Mapping
from dataclasses import replace

import numpy as np

from master.diagnosis.numerics.arrays import Array
from master.diagnosis.numerics.ceiling import Ceiling, ceiling, history
from master.diagnosis.numerics.drift import Drift, drift
from master.diagnosis.numerics.least_squares import Fit, Mask
from master.diagnosis.numerics.whiteness import cross_correlations, ljung_box
from master.diagnosis.search.screening import Tangent
from master.diagnosis.search.study import Extended, Study

from .part_result import PartResult

N_GROUPS = 8
LAGS = (0.01, 0.03, 0.1)
SHAPES: dict[str, Callable[[Array], Array]] = {
    "abs": np.abs,
    "squared": lambda f: f * f,
    "cubed": lambda f: f * f * f,
    "sign": np.sign,
}


def detect(result: PartResult) -> PartResult:
    """Tests on the residual of the base; they are reported."""
    study = result.study
    study.progress(f"{study.bench.part.name}: tests on the residual")
    left = study.measured - result.base.predicted
    worst = worst_output(study)
    rows = study.bench.in_use
    features = features_of(study)
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
        ceiling=ceiling_of(study, left[:, worst], features),
        drifts=drifts(study, Extended(), result.base),
    )


def worst_output(study: Study) -> int:
    """Index of the output that the base explains worst."""
    return int(np.argmax(study.size / np.maximum(study.measured.std(axis=0), 1e-300)))


def features_of(study: Study) -> dict[str, Array]:
    """Signals of all slots on the compared rows, each once."""
    found: dict[str, Array] = {}
    for slot, signals in study.signals.items():
        for role, values in signals.items():
            rows = study.bench.compared_rows(values)
            if np.ptp(rows) > 0.0 and not any(_alike(rows, other) for other in found.values()):
                found[f"{slot} {role}"] = rows
    return found


def _alike(a: Array, b: Array) -> bool:
    return bool(abs(np.corrcoef(a, b)[0, 1]) > 0.9999)


def ceiling_of(study: Study, left: Array, features: Mapping[str, Array]) -> Ceiling | None:
    """How much of a residual any law of the slots' signals could explain; None without signals."""
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


def drifts(study: Study, chosen: Extended, found: Fit) -> tuple[Drift, ...]:
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

"""Evidence in the residual of the base: correlations, parameters that drift. It is reported."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from master.diagnosis.numerics.arrays import TINY, Array
from master.diagnosis.numerics.drift import Drift, drift
from master.diagnosis.numerics.least_squares import Fit
from master.diagnosis.numerics.whiteness import cross_correlations, ljung_box, variance_inflation
from master.diagnosis.search.extended_model import ExtendedModel
from master.diagnosis.search.study import Study
from master.diagnosis.search.tangent import Tangent

from .part_result import PartResult

N_GROUPS = 8  # of rows, in time order, for parameters that drift
N_CORRELATIONS = 10
SAME_SIGNAL = 0.9999  # correlation of two signals that are one


def detect(result: PartResult) -> PartResult:
    """Test the residual of the base; the tests are reported."""
    study = result.study
    study.say("tests on the residual")
    left = study.measured - result.base.predicted
    worst = worst_output(study)
    rows = study.bench.in_use
    features = features_of(study)
    bases = {}
    linear = {}
    for name, feature in features.items():
        linear[name] = feature[rows]
        for shape, values in shapes_of(feature[rows]).items():
            if np.ptp(values) > 0.0:
                bases[f"{name} {shape}"] = values
    correlations = cross_correlations(left[rows, worst], bases, linear=linear) if bases else []
    return replace(
        result,
        correlations=tuple(correlations[:N_CORRELATIONS]),
        whiteness=ljung_box(left[rows, worst]),
        drifts=drifts(study, ExtendedModel(), result.base),
    )


def shapes_of(feature: Array) -> dict[str, Array]:
    """Functions of a signal that a residual may follow, by name, shape of the signal."""
    return {
        "abs": np.abs(feature),
        "squared": feature * feature,
        "cubed": feature * feature * feature,
        "sign": np.sign(feature),
    }


def worst_output(study: Study) -> int:
    """Index of the output that the base explains worst."""
    return int(np.argmax(study.output_scale / np.maximum(study.measured.std(axis=0), TINY)))


def features_of(study: Study) -> dict[str, Array]:
    """Signals of all slots on the compared rows that move, each once, shape (rows,)."""
    features: dict[str, Array] = {}
    for place, signals in study.signals.items():
        for role, values in signals.items():
            rows = study.bench.compared_rows(values)
            if np.ptp(rows) > 0.0 and not any(_alike(rows, other) for other in features.values()):
                features[f"{place} {role}"] = rows
    return features


def _alike(a: Array, b: Array) -> bool:
    return bool(abs(np.corrcoef(a, b)[0, 1]) > SAME_SIGNAL)


def drifts(study: Study, model: ExtendedModel, fitted: Fit) -> tuple[Drift, ...]:
    """Parameters fitted on groups of rows alone, by one linear step."""
    tangent = Tangent(study, model, fitted)
    if not tangent.columns:
        return ()
    rows = np.flatnonzero(study.fit_rows)
    k = study.measured.shape[1]
    steps = []
    deviations = []
    times = []
    amplitudes = []
    for group in np.array_split(np.arange(len(rows)), N_GROUPS):
        index = (group[:, None] * k + np.arange(k)).ravel()
        a = np.column_stack([c[index] for c in tangent.columns])
        r = tangent.residual[index]
        normal = np.linalg.pinv(a.T @ a + tangent.prior.T @ tangent.prior)
        steps.append(normal @ (a.T @ r))
        variance = float(np.mean(r * r)) * variance_inflation(r)
        deviations.append(np.sqrt(np.maximum(np.diag(normal), TINY) * variance))
        times.append(float(rows[group].mean()) * study.bench.row_period)
        amplitudes.append(float(study.measured[rows[group], 0].std()))
    covariates = {"time": np.array(times), "amplitude": np.array(amplitudes)}
    return tuple(
        drift(p.name, fitted.values[p.name] + np.array(steps)[:, i], np.array(deviations)[:, i], covariates)
        for i, p in enumerate(tangent.parameters)
    )

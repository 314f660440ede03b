"""
A sign that was rounded as little as the search allows, rounded less.

The search keeps signs smooth enough for any integrator. Where the best law is at that bound, a sharper sign
may be nearer to what was measured: it is taken where the fit says so, and a replay that does not bear it
leaves the fit worse.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from fmu_sources.effects.framework.common import SMOOTHING
from master.diagnosis.numerics.least_squares import FreeParameter
from master.diagnosis.search.study import FINE

from .part_result import PartResult

SHARPER = (0.3, 0.1, 0.02)  # first guesses, over the bound of the search
SHARPEST = 0.01  # the bound then
LEAST_GAIN = 10.0  # of twice the log likelihood of white noise: a chance of 1 in 600


def with_sharp_reversals(result: PartResult) -> PartResult:
    """Fit once more with sharper signs, where a rounding is at the least that the search allows."""
    fit, model = result.fit, result.chosen
    rounded = {
        name
        for name in fit.at_bound
        for placed in model.effects
        if placed.owns(name) and placed.short_name(name) == SMOOTHING
    }
    if not rounded or (result.learned is not None and result.learned.model == model):
        return result
    sharper = replace(
        model, parameters=tuple(_sharper(p) if p.name in rounded else p for p in model.parameters)
    )
    study = result.study
    study.say("a sharper sign")
    guesses = [
        dict(fit.values) | {p.name: share * p.low for p in model.parameters if p.name in rounded}
        for share in SHARPER
    ]
    found = study.fitted(sharper, guesses, FINE)
    n_values = study.fit_rows.sum() * study.measured.shape[1]
    if n_values * np.log(fit.cost / found.cost) < LEAST_GAIN:
        return result
    return replace(result, chosen=sharper.started_at(found.values), fit=found)


def _sharper(p: FreeParameter) -> FreeParameter:
    return replace(p, low=SHARPEST * p.low)

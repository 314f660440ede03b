"""
A sign that was rounded as little as the search allows, rounded less.

The search keeps signs smooth enough for any integrator. Where the best law is at that bound, a sharper sign
may be nearer to what was measured: it is taken where it pays on held-out blocks, as an effect would have to.
A replay that does not bear it pays nothing.
"""

from __future__ import annotations

from dataclasses import replace

from fmu_sources.effects.framework.common import SMOOTHING
from master.diagnosis.numerics.gains import is_accepted
from master.diagnosis.numerics.least_squares import FreeParameter
from master.diagnosis.search.study import FINE

from .part_result import PartResult

SHARPER = (0.3, 0.1, 0.02)  # first guesses, over the bound of the search
SHARPEST = 0.01  # the bound then


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
    if not is_accepted(study.gain(fit, found), 1, is_first=False):
        return result
    return replace(result, chosen=sharper.started_at(found.values), fit=found)


def _sharper(p: FreeParameter) -> FreeParameter:
    return replace(p, low=SHARPEST * p.low)

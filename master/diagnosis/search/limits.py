"""A law at an end of its parameters is another law, or none: it is named by what it has become."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

from fmu_sources.effects.framework.limit import Limit
from master.diagnosis.replay.placed_effect import PlacedEffect, fixed_values, free_parameters

from .extended_model import ExtendedModel
from .families import is_beaten
from .rounds import SearchResult
from .study import FINE, Study

MOST = 4  # limits that are followed, one after the other


def limit_of(study: Study, placed: PlacedEffect, values: Mapping[str, float]) -> Limit | None:
    """Limit that an effect is at, with its values by `fmu.variable`; None if it is at none."""
    own = {v.name: v.start for v in placed.law.parameters}
    own |= {placed.short_name(k): v for k, v in values.items() if placed.owns(k)}
    return placed.law.limit(own, study.signal_rms(placed.place))


def named_by_limits(study: Study, result: SearchResult, candidates: Sequence[PlacedEffect]) -> SearchResult:
    """
    Replace each effect that is at a limit by what it is there, as long as that explains as much.

    Members of families that are at a limit are the law that they have become, and no rivals of it.
    """
    for _ in range(MOST):
        replaced = _once(study, result, candidates)
        if replaced is None:
            break
        result = replaced
    rounds = []
    for step in result.rounds:
        family = [
            r
            for i, r in enumerate(step.family)
            if i == 0 or not _is_at_limit(study, r.model, r.gain.fit.values)
        ]
        rounds.append(replace(step, family=tuple(family)))
    return replace(result, rounds=tuple(rounds))


def _is_at_limit(study: Study, model: ExtendedModel, values: Mapping[str, float]) -> bool:
    return limit_of(study, model.effects[-1], dict(model.fixed) | dict(values)) is not None


def _once(study: Study, result: SearchResult, candidates: Sequence[PlacedEffect]) -> SearchResult | None:
    """The result with one effect named by its limit; None if there is none, or that explains less."""
    values = dict(result.model.fixed) | dict(result.fit.values)
    for placed in result.model.effects:
        limit = limit_of(study, placed, values)
        if limit is None:
            continue
        other = _become(study, result.model, placed, limit, values, candidates)
        if other is None:
            continue
        study.say(f"{placed} is at a limit: {limit.because}")
        study.build([other.effects])
        fitted = study.fitted(other, [result.fit.values], FINE)
        if not is_beaten(study, study.gain(result.base, fitted), study.gain(result.base, result.fit)):
            return replace(result, model=other.started_at(fitted.values), fit=fitted)
    return None


def _become(
    study: Study,
    model: ExtendedModel,
    placed: PlacedEffect,
    limit: Limit,
    values: Mapping[str, float],
    candidates: Sequence[PlacedEffect],
) -> ExtendedModel | None:
    """The model with what an effect becomes in its place."""
    less = model.without(placed)
    if limit.becomes is None:
        return less
    other = replace(placed, effect=limit.becomes)
    if other in model.effects:
        return less
    if other not in candidates:
        return None
    rms = study.signal_rms(other.place)
    own = {v.name: v.start for v in placed.law.parameters}
    own |= {placed.short_name(k): v for k, v in values.items() if placed.owns(k)}
    there = {other.variable(name): value for name, value in limit.values(own).items()}
    fixed = fixed_values(other, rms, other.law.variants[0])
    free = tuple(replace(p, start=there.get(p.name, p.start)) for p in free_parameters(other, rms))
    return less.with_effect(other, fixed, free)

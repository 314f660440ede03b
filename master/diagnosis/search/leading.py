"""Of effects that cannot be told apart, one leads that nothing speaks against and whose numbers are known."""

from __future__ import annotations

from dataclasses import replace

from master.diagnosis.numerics.least_squares import Fit
from master.diagnosis.replay.placed_effect import PlacedEffect

from .extended_model import ExtendedModel
from .families import Ranked, is_beaten
from .objections import objections
from .rounds import SearchResult
from .study import FINE, Study
from .unknown_numbers import of_effect, unknown_numbers


def led_by_the_unobjected(study: Study, result: SearchResult) -> SearchResult:
    """Put another member of its family in the place of each effect that something speaks against."""
    for i, step in enumerate(result.rounds):
        if not step.family:
            continue
        leader = step.family[0].model.effects[-1]
        if leader not in result.model.effects or is_unobjected(study, result.model, result.fit, leader):
            continue
        for member in step.family[1:]:
            other = _led_by(study, result, leader, member)
            if other is None:
                continue
            family = (member, *(r for r in step.family if r is not member))
            rounds = (*result.rounds[:i], replace(step, family=family), *result.rounds[i + 1 :])
            result = replace(other, rounds=rounds)
            break
    return result


def is_unobjected(study: Study, model: ExtendedModel, fit: Fit, placed: PlacedEffect) -> bool:
    """Whether nothing speaks against an effect of a fitted model, and all its numbers are known."""
    against = objections(study, model, fit)
    return str(placed) not in against and not of_effect(placed, unknown_numbers(study, model, fit))


def _led_by(study: Study, result: SearchResult, leader: PlacedEffect, member: Ranked) -> SearchResult | None:
    """A member in the leader's place; None if it explains less, or something speaks against it too."""
    placed = member.model.effects[-1]
    if placed in result.model.effects:
        return None
    fixed = {k: v for k, v in member.model.fixed.items() if placed.owns(k)}
    free = tuple(p for p in member.model.parameters if placed.owns(p.name))
    other = result.model.without(leader).with_effect(placed, fixed, free)
    study.say(f"{placed} in the place of {leader}")
    study.build([other.effects])
    starts = [dict(member.gain.fit.values), dict(member.gain.fit.values) | dict(result.fit.values)]
    fitted = study.fitted(other, starts, FINE)
    if not is_unobjected(study, other, fitted, placed):
        return None
    if is_beaten(study, study.gain(result.base, fitted), study.gain(result.base, result.fit)):
        return None
    return replace(result, model=other.started_at(fitted.values), fit=fitted)

"""One law or two: what the library has as one effect may be two others at once."""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Sequence
from dataclasses import replace

from master.diagnosis.replay.placed_effect import PlacedEffect, fixed_values, free_parameters

from .extended_model import ExtendedModel
from .families import is_beaten
from .rounds import Round, SearchResult
from .study import FINE, Study

AND = " and "


def with_rewritings(study: Study, result: SearchResult, candidates: Sequence[PlacedEffect]) -> SearchResult:
    """
    Put others in the place of an effect that equals their sum, where they explain more.

    Where they explain as much, the effect and they are a family.
    """
    for step in result.rounds:
        for member in step.family:
            for parts in _parts(member.model.effects[-1], candidates, result.model.effects):
                study.say(f"{AND.join(map(str, parts))} in its place")
                result = _decided(study, result, step, parts)
    return result


def _decided(study: Study, result: SearchResult, step: Round, parts: Sequence[PlacedEffect]) -> SearchResult:
    old = step.family[0].model.effects[-1]
    if old not in result.model.effects:
        return result
    other = _instead(study, result.model, old, parts)
    study.build([other.effects])
    fitted = study.fitted(other, [result.fit.values], FINE)
    one = study.gain(result.base, result.fit)
    two = study.gain(result.base, fitted)
    if is_beaten(study, two, one):
        return result
    if is_beaten(study, one, two):
        rounds = tuple(replace(r, family=r.family[:1]) if r is step else r for r in result.rounds)
        return replace(result, model=other.started_at(fitted.values), fit=fitted, rounds=rounds)
    return replace(result, rewritings=(*result.rewritings, (str(old), AND.join(map(str, parts)))))


def _parts(
    placed: PlacedEffect, candidates: Sequence[PlacedEffect], taken: Sequence[PlacedEffect]
) -> Iterator[tuple[PlacedEffect, ...]]:
    """All ways to place what a law equals the sum of; the first goes where the law was."""
    places = [
        [e for e in candidates if e.effect == name and e not in taken] for name in placed.law.equals_sum_of
    ]
    if places:
        places[0] = [e for e in places[0] if e.place == placed.place]
        yield from itertools.product(*places)


def _instead(
    study: Study, chosen: ExtendedModel, old: PlacedEffect, parts: Sequence[PlacedEffect]
) -> ExtendedModel:
    model = chosen.without(old)
    for placed in parts:
        rms = study.signal_rms(placed.place)
        fixed = fixed_values(placed, rms, placed.law.variants[0])
        model = model.with_effect(placed, fixed, free_parameters(placed, rms))
    return model

"""
Names beside a law without a name, once that has taken the place of the names before it.

A law that is learned takes up what no name explains; what is left then may have a name after all. It is
fitted together with the law, whose shape is free to change, and stays where the law alone is worse.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from master.diagnosis.adequacy.channels import Judge
from master.diagnosis.numerics.gains import is_accepted
from master.diagnosis.replay.placed_effect import PlacedEffect
from master.diagnosis.search.first_order import FirstOrder
from master.diagnosis.search.rounds import SMALLEST_PROMISE
from master.diagnosis.search.screening import Screened, screened, unbuilt
from master.diagnosis.unnamed_law.fit import Descent
from master.diagnosis.unnamed_law.learn import LearnedLaw

from .part_result import PartResult

MOST_FITTED = 2  # names that are fitted beside a law


def with_names_beside(result: PartResult, effects: Sequence[PlacedEffect], judge: Judge) -> PartResult:
    """
    Add the name that explains most beside a learned law, where the law alone is not adequate.

    Args:
        result: A part; it is returned as it is unless a law without a name is all that was chosen.
        effects: Effects that may be named.
        judge: Of what a prediction leaves.
    """
    law = result.learned
    if law is None or result.is_named or result.chosen.effects != law.model.effects[-1:]:
        return result
    if all(c.is_adequate for c in judge.judge(law.fit.predicted, thorough=False)):
        return result
    study = result.study
    study.say("names beside the law")
    promising = _promising(law, result, effects)
    study.build([(s.model.effects[-1], *law.model.effects) for s in promising])
    tried = [_fitted(law, s, result) for s in promising]
    kept = [own for own in tried if _is_needed(own, law, result, len(effects))]
    best = max(kept, key=lambda own: own.gain.mean, default=None)
    return result if best is None else replace(result, learned=best, chosen=best.model, fit=best.fit)


def _promising(law: LearnedLaw, result: PartResult, effects: Sequence[PlacedEffect]) -> list[Screened]:
    study = result.study
    first_order = FirstOrder(study, law.model, law.fit)
    taken = law.model.effects[-1].place
    needed = unbuilt(study, first_order, effects)
    study.build([(*law.model.effects, e) if e.place == taken else (e,) for e in needed])
    tried = screened(study, law.model, law.fit, effects, first_order=first_order)
    return [s for s in tried[:MOST_FITTED] if s.gain > SMALLEST_PROMISE]


def _fitted(law: LearnedLaw, candidate: Screened, result: PartResult) -> LearnedLaw:
    """Fit a name and the law together; the law's coefficients are the last of the parameters."""
    study = result.study
    name = candidate.model.without(law.model.effects[-1])
    placed = law.model.effects[-1]
    model = name.with_effect(placed, law.model.fixed, law.model.parameters)
    values = dict(law.fit.values) | dict(candidate.starts[0])
    given = dict(model.fixed) | values
    predicted = study.simulate(model.effects, given, everything=True)
    start = replace(law.fit, values=values, predicted=predicted)
    fitted = Descent(study, model, law.promise).fit(start)
    return replace(law, model=model, gain=study.gain(result.base, fitted))


def _is_needed(own: LearnedLaw, law: LearnedLaw, result: PartResult, n_tried: int) -> bool:
    return is_accepted(result.study.gain(law.fit, own.fit), n_tried, is_first=False)

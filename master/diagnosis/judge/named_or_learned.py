"""
Names, or a nonparametric law?

Nonparametric laws are always tried: alone, and in addition to the names where there are some. The names
hold if no law does better alone and none explains much in addition to them; such a law is their remainder.
A law that does better alone than all names takes their place: what it explains is of no listed kind. Where
the refit has biased the parameters, they make up for what is missing: a law is then sought from the values
of the system as well.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from master.diagnosis.adequacy.channels import Judge
from master.diagnosis.numerics.arrays import TINY
from master.diagnosis.numerics.gains import is_accepted
from master.diagnosis.numerics.least_squares import Fit
from master.diagnosis.search.extended_model import ExtendedModel
from master.diagnosis.search.families import is_beaten
from master.diagnosis.search.rounds import SearchResult
from master.diagnosis.search.study import Study
from master.diagnosis.unnamed_law.learn import LearnedLaw, learn

from .part_result import PartResult
from .stages import Stage

SMALL_REMAINDER = 0.05  # share of the explained power that is no remainder
NAMED_SHARE = 0.8  # share that names must explain to hold against a law alone
BIASED = 2.0  # deviations of the prior


@dataclass(frozen=True)
class Rivals:
    """The search's names, a law alone and a law added to the names; None where there is none worth it."""

    study: Study
    search: SearchResult
    alone: LearnedLaw | None
    in_addition: LearnedLaw | None

    @property
    def alone_wins(self) -> bool:
        """
        Whether the law alone takes the place of the names.

        It predicts better, block by block; and they leave a part and it hardly does, or they are several in
        one slot.
        """
        if self.alone is None:
            return False
        named = self.study.gain(self.search.base, self.search.fit)
        if not is_beaten(self.study, named, self.alone.gain):
            return False
        if self.named_share < 1.0 - SMALL_REMAINDER:
            return self.alone_share > 1.0 - SMALL_REMAINDER or self.named_share < NAMED_SHARE
        return _is_crowded(self.search)

    @property
    def alone_share(self) -> float:
        """Share of what names and law explain together that the law alone explains."""
        return 1.0 if self.alone is None else self._share(self.alone.fit)

    @property
    def named_share(self) -> float:
        """Share of what names and law explain together that the names explain."""
        return self._share(self.search.fit)

    def _share(self, fit: Fit) -> float:
        laws = [law.fit for law in (self.alone, self.in_addition) if law is not None]
        base = self._power(self.search.base)
        own = self._power(fit)
        least = min(own, *(self._power(law) for law in laws)) if laws else own
        return (base - own) / max(base - least, TINY)

    def _power(self, fit: Fit) -> float:
        return float(self.study.powers(fit.predicted).mean())


def named_or_learned(
    result: PartResult, search: SearchResult, places: Sequence[str], judge: Judge
) -> PartResult:
    """
    Keep the names, add a nonparametric law to them, or put one in their place.

    Where nothing recorded predicts what is left, no law is sought: there is none to be found.
    """
    study = result.study
    if not search.model.effects:
        result = replace(result, search=search)
        if all(c.is_silent for c in result.final.channels):
            return result
        law = _alone(study, search.base, places)
        return result if law is None else _undeclared(result, law)
    named = Stage(search.model.name, judge.judge(search.fit.predicted, thorough=False))
    if all(c.is_silent for c in named.channels):
        return replace(result, search=search, chosen=search.model, fit=search.fit)
    in_addition = _accepted(learn(study, search.model, search.fit, places))
    alone = None
    if in_addition is not None or _is_crowded(search) or _leaves_much(study, search):
        alone = _alone(study, search.base, places)
    rivals = Rivals(study, search, alone, in_addition)
    is_steady = in_addition is not None and is_accepted(in_addition.gain, in_addition.n_tried, is_first=False)
    has_remainder = is_steady and 1.0 - rivals.named_share > SMALL_REMAINDER
    if has_remainder or named.is_predictable:
        search = search.widened(study)
    result = replace(result, search=search, chosen=search.model, fit=search.fit)
    if alone is not None and rivals.alone_wins:
        return _undeclared(result, alone)
    if in_addition is None or not has_remainder:
        return result
    return replace(
        result,
        has_remainder=True,
        learned=in_addition,
        chosen=in_addition.model,
        fit=in_addition.fit,
    )


def _alone(study: Study, base: Fit, places: Sequence[str]) -> LearnedLaw | None:
    """A law without names, from the refitted model or, where that is biased, from the system's values."""
    law = _accepted(learn(study, ExtendedModel(), base, places))
    if law is not None or not is_biased(study, base):
        return law
    nominal = study.nominal()
    from_nominal = replace(study, slot_values=nominal.values)
    law = learn(from_nominal, ExtendedModel(), nominal, places, reference=base)
    return law and _accepted(replace(law, n_tried=2 * law.n_tried))


def is_biased(study: Study, fitted: Fit) -> bool:
    """Whether a parameter of the base is at a bound, or farther off than its prior holds possible."""
    far = [abs(p.prior_distance(fitted.values[p.name])) > BIASED for p in study.base]
    return any(far) or any(p.name in fitted.at_bound for p in study.base)


def _leaves_much(study: Study, search: SearchResult) -> bool:
    base = study.powers(search.base.predicted).mean()
    own = study.powers(search.fit.predicted).mean()
    return bool(own > (1.0 - NAMED_SHARE) * base)


def _is_crowded(search: SearchResult) -> bool:
    """Whether one slot holds several names: one law may be the cause of them all."""
    places = [e.place for e in search.model.effects]
    return len(set(places)) < len(places)


def _accepted(law: LearnedLaw | None) -> LearnedLaw | None:
    return law if law is not None and is_accepted(law.gain, law.n_tried) else None


def _undeclared(result: PartResult, law: LearnedLaw) -> PartResult:
    return replace(result, learned=law, chosen=law.model, fit=law.fit, is_named=False)

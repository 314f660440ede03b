"""
Names, or a law without a name?

Laws without a name are always tried: alone, and beside the names where there are some. The names stand if no
law does better alone and none explains much beside them; a law beside them is their remainder. A law that
does better alone than all names takes their place: what it explains is of no listed kind. Where the refit has
strained the parameters, it has bent the model to stand for what is missing: a law is then sought from the
values of the system as well.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from master.diagnosis.numerics.arrays import Array
from master.diagnosis.numerics.gains import powers
from master.diagnosis.numerics.least_squares import Fit
from master.diagnosis.search.families import is_accepted, is_beaten
from master.diagnosis.search.rounds import Found
from master.diagnosis.search.study import Extended, Study
from master.diagnosis.unnamed_law.learn import Learned, learn

from .evidence import ceiling_of, features_of, worst_output
from .part_result import PartResult

SMALL_REMAINDER, NAMED_SHARE = 0.05, 0.8
STRAIN = 2.0  # deviations of the prior


@dataclass(frozen=True)
class _Rivals:
    """The search's names, a law alone and a law beside the names; None where there is none worth it."""

    study: Study
    found: Found
    alone: Learned | None
    beside: Learned | None

    @property
    def alone_wins(self) -> bool:
        """
        Whether the law alone takes the place of the names.

        It predicts better, block by block; and they leave a part and it hardly does, or they are several in
        one slot.
        """
        if self.alone is None:
            return False
        named = self.study.gain(self.found.base, self.found.fit)
        if not is_beaten(self.study, named, self.alone.gain):
            return False
        if self.named_share < 1.0 - SMALL_REMAINDER:
            return self.alone_share > 1.0 - SMALL_REMAINDER or self.named_share < NAMED_SHARE
        return _is_crowded(self.found)

    @property
    def alone_share(self) -> float:
        """Share of what names and law explain together that the law alone explains."""
        return 1.0 if self.alone is None else self._share(self.alone.fit)

    @property
    def named_share(self) -> float:
        """Share of what names and law explain together that the names explain."""
        return self._share(self.found.fit)

    def _share(self, fit: Fit) -> float:
        laws = [law.fit for law in (self.alone, self.beside) if law is not None]
        base, own, *others = (float(self._power(f).mean()) for f in (self.found.base, fit, *laws))
        return (base - own) / max(base - min(own, *others), 1e-300)

    def _power(self, fit: Fit) -> Array:
        return powers(fit.predicted - self.study.measured, self.study.held_out, self.study.size)


def named_or_learned(result: PartResult, found: Found, slots: Sequence[str]) -> PartResult:
    """Keep the names, put a law without a name beside them, or in their place."""
    study = result.study
    if not found.extended.added:
        law = _alone(study, found.base, slots)
        result = replace(result, found=found)
        return result if law is None else _undeclared(result, law)
    beside = _accepted(learn(study, found.extended, found.fit, slots))
    alone = None
    if beside is not None or _is_crowded(found) or _leaves_much(study, found):
        alone = _alone(study, found.base, slots)
    rivals = _Rivals(study, found, alone, beside)
    left = study.measured - found.fit.predicted
    after = ceiling_of(study, left[:, worst_output(study)], features_of(study))
    is_steady = beside is not None and is_accepted(beside.gain, beside.n_tried, is_first=False)
    has_remainder = is_steady and 1.0 - rivals.named_share > SMALL_REMAINDER
    if has_remainder or (after is not None and after.is_structure):
        found = found.widened(study)
    result = replace(result, found=found, chosen=found.extended, fit=found.fit, ceiling_after=after)
    if alone is not None and rivals.alone_wins:
        return _undeclared(result, alone)
    if beside is None or not has_remainder:
        return result
    return replace(result, has_remainder=True, learned=beside, chosen=beside.extended, fit=beside.fit)


def _alone(study: Study, base: Fit, slots: Sequence[str]) -> Learned | None:
    """A law without names, from the refitted model or, where that is strained, from the system's values."""
    law = _accepted(learn(study, Extended(), base, slots))
    if law is not None or not is_strained(study, base):
        return law
    start = study.nominal()
    other = replace(study, signals={})
    other.look_into_slots(start)
    law = learn(other, Extended(), start, slots, over=base)
    return law and _accepted(replace(law, n_tried=2 * law.n_tried))


def is_strained(study: Study, found: Fit) -> bool:
    """Whether a parameter of the base is at a bound, or farther off than its prior holds possible."""
    far = [
        abs(found.values[p.name] - p.start) > STRAIN * p.spread for p in study.base if p.spread is not None
    ]
    return any(far) or any(p.name in found.at_bound for p in study.base)


def _leaves_much(study: Study, found: Found) -> bool:
    base, own = (
        powers(f.predicted - study.measured, study.held_out, study.size).mean()
        for f in (found.base, found.fit)
    )
    return bool(own > (1.0 - NAMED_SHARE) * base)


def _is_crowded(found: Found) -> bool:
    """Whether one slot holds several names: one law may be behind them."""
    slots = [(a.fmu, a.slot) for a in found.extended.added]
    return len(set(slots)) < len(slots)


def _accepted(law: Learned | None) -> Learned | None:
    return law if law is not None and is_accepted(law.gain, law.n_tried) else None


def _undeclared(result: PartResult, law: Learned) -> PartResult:
    return replace(result, learned=law, chosen=law.extended, fit=law.fit, is_named=False)

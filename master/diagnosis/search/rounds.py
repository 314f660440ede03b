"""
Forward search: screen, fit the promising, rank on held-out blocks, add the winner, again.

What cannot be told from the winner is its family; the next effect may decide in it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from master.diagnosis.numerics.arrays import Array
from master.diagnosis.numerics.gains import powers
from master.diagnosis.numerics.least_squares import Fit
from master.diagnosis.replay.candidate_models import Added

from .families import (
    NEAR,
    Ranked,
    act_alike,
    best_first,
    contains,
    family,
    is_accepted,
    is_beaten,
    is_confused,
)
from .screening import Screened, screened
from .study import Extended, Study

AT_MOST = 3
PRECISELY = (60, 1e-8)  # evaluations, tolerance
LONGEST_LIST, FEWEST, SMALLEST_PROMISE = 6, 1, 5e-3
ENOUGH, MOST = 5e-3, 0.5
MOST_BRANCHES = 2
FALLS = 0.01  # of the cost


@dataclass(frozen=True)
class Round:
    """One round: all that were fitted, best first; the family, winner first; if the next round decided."""

    before: Fit
    ranked: tuple[Ranked, ...]
    family: tuple[Ranked, ...]
    is_resolved: bool = False


@dataclass(frozen=True)
class Found:
    """What a search ends with; `rewritings` are families of an effect and others that make it together."""

    base: Fit
    extended: Extended
    fit: Fit
    rounds: tuple[Round, ...]
    rewritings: tuple[tuple[str, ...], ...] = ()

    @property
    def families(self) -> list[tuple[str, ...]]:
        """Names that could not be told apart, one tuple an effect that was added."""
        found = [tuple(r.name for r in rnd.family) for rnd in self.rounds if len(rnd.family) > 1]
        return [*found, *self.rewritings]

    def widened(self, study: Study) -> Found:
        """
        The same with wider families, for a residual that still has structure.

        What the best leaves is not noise then, and statistics of noise do not decide between rivals that
        leave nearly as little.
        """
        return replace(self, rounds=tuple(_widened(study, step) for step in self.rounds))


def search(study: Study, base: Fit, wanted: Sequence[Added], at_most: int = AT_MOST) -> Found:
    """Add effects one after the other until none is accepted."""
    chosen, found = Extended(), base
    rounds: list[Round] = []
    ahead: Round | None = None
    while len(rounds) < at_most:
        step = ahead or _step(study, chosen, found, wanted)
        ahead = None
        is_last = len(rounds) + 1 == at_most
        if len(step.family) > 1 and not is_last and not _is_enough(study, base, step.family[0].gain.fit):
            step, ahead = _looked_ahead(study, base, step, wanted)
        if _is_enough(study, base, found):
            step = _most_of_the_rest(step)
        if step.family and chosen.added:
            again = study.fitted(chosen, [step.family[0].gain.fit.values], *PRECISELY)
            if again.cost < (1.0 - FALLS) * found.cost:  # the effects before were not at their best
                chosen, found, ahead = chosen.started_at(again.values), again, None
                continue
        rounds.append(step)
        if not step.family:
            break
        winner = step.family[0]
        chosen, found = winner.extended.started_at(winner.gain.fit.values), winner.gain.fit
        pruned, found = _pruned(study, chosen, found)
        if pruned.added != chosen.added:
            chosen, ahead = pruned, None
    if chosen.added:
        found = study.fitted(chosen, [found.values], *PRECISELY)
    return Found(base, chosen, found, tuple(rounds))


def _most_of_the_rest(step: Round) -> Round:
    """
    Accept only what explains most of the little that is left.

    A strong effect's model has faults of its own, and other laws explain parts of them.
    """
    return step if step.family and step.family[0].gain.share > MOST else replace(step, family=())


def _step(study: Study, chosen: Extended, found: Fit, wanted: Sequence[Added]) -> Round:
    """Screen and fit one more effect."""
    left = [a for a in wanted if a not in chosen.added]
    study.progress(f"{study.bench.part.name}: {len(left)} effects screened")
    taken = {(a.fmu, a.slot) for a in chosen.added}
    first = [(*chosen.added, a) if (a.fmu, a.slot) in taken else (a,) for a in left]
    study.pool.build(first, study.progress)
    promising = _shortlist(screened(study, chosen, found, left))
    study.pool.build([s.extended.added for s in promising], study.progress)
    return _round(study, found, promising, len(left))


def _looked_ahead(study: Study, base: Fit, step: Round, wanted: Sequence[Added]) -> tuple[Round, Round]:
    """Let the next effect decide between the members of a family; the round after the winner beside it."""

    def is_inferior(one: Ranked, other: Ranked) -> bool:
        return is_beaten(study, one.gain, other.gain) or contains(study, base, one, other)

    branches = []
    for member in step.family[:MOST_BRANCHES]:
        after = _step(study, member.extended.started_at(member.gain.fit.values), member.gain.fit, wanted)
        last = after.family[0] if after.family else member
        branches.append((replace(last, gain=study.gain(base, last.gain.fit)), member, after))
    best = branches[0]
    for branch in branches[1:]:
        if is_inferior(best[0], branch[0]) and not is_beaten(study, branch[0].gain, best[0].gain):
            best = branch
    inferior = [m for end, m, _ in branches if end is not best[0] and is_inferior(end, best[0])]
    inferior += step.family[MOST_BRANCHES:]
    others = [m for m in step.family if m is not best[1] and (m not in inferior or is_confused(m, best[1]))]
    kept = (best[1], *others)
    return replace(step, family=kept, is_resolved=len(kept) == 1), best[2]


def _power(study: Study, found: Fit) -> Array:
    return powers(found.predicted - study.measured, study.held_out, study.size)


def _is_enough(study: Study, base: Fit, found: Fit) -> bool:
    """Whether next to nothing is left: less than a fourteenth of the amplitude."""
    return bool(_power(study, found).sum() < ENOUGH * _power(study, base).sum())


def _pruned(study: Study, chosen: Extended, found: Fit) -> tuple[Extended, Fit]:
    """Drop an effect that a later one has made needless."""
    for old in chosen.added[:-1]:
        begin = f"{old.fmu}.{old.prefix}_"
        less = Extended(
            tuple(a for a in chosen.added if a != old),
            {k: v for k, v in chosen.fixed.items() if not k.startswith(begin)},
            tuple(p for p in chosen.parameters if not p.name.startswith(begin)),
        )
        study.pool.build([less.added], study.progress)
        without = study.fitted(less, [found.values])
        if not is_accepted(study.gain(without, found), 1, is_first=False):
            return _pruned(study, less.started_at(without.values), without)
    return chosen, found


def _shortlist(tried: Sequence[Screened]) -> list[Screened]:
    """The most promising; with one that acts like a lag all that do in its slot."""
    best = tried[0].gain if tried else 0.0
    least = max(SMALLEST_PROMISE, 0.1 * best)
    kept = [s for i, s in enumerate(tried[:LONGEST_LIST]) if s.gain >= least or i < FEWEST]
    return kept + [s for s in tried if s not in kept and act_alike(s.extended, tried[0].extended)]


def _round(study: Study, before: Fit, promising: Sequence[Screened], n_tried: int) -> Round:
    is_first = all(len(s.extended.added) == 1 for s in promising)
    ranked = []
    for s in promising:
        study.progress(f"{study.bench.part.name}: fit of {s.extended.name}")
        found = study.fitted(s.extended, s.starts, known=s.known)
        ranked.append(Ranked(s.extended, study.gain(before, found)))
    accepted = [r for r in best_first(ranked) if is_accepted(r.gain, n_tried, is_first=is_first)]
    refined = [_refined(study, before, r) for r in family(study, before, accepted)]
    others = [r for r in ranked if r.name not in {own.name for own in refined}]
    kept = family(study, before, best_first(refined))
    return Round(before, tuple(best_first([*others, *refined])), tuple(kept))


def _refined(study: Study, before: Fit, r: Ranked) -> Ranked:
    """Fit a member of a family to the end: what a first fit leaves would pass for another effect."""
    found = study.fitted(r.extended, [r.gain.fit.values], *PRECISELY)
    return replace(r, gain=study.gain(before, found)) if found.cost < r.gain.fit.cost else r


def _widened(study: Study, step: Round) -> Round:
    if not step.family or step.is_resolved:
        return step
    winner = step.family[0]
    near = [r for r in step.ranked if r.gain.is_accepted and winner.gain.mean - r.gain.mean < NEAR]
    others = [r for r in near if r not in step.family and not contains(study, step.before, r, winner)]
    return replace(step, family=(*step.family, *others))

"""
Forward search: screen, fit the promising, rank on held-out blocks, add the winner, again.

What is indistinguishable from the winner is its family; the next effect may decide in it.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

from master.diagnosis.numerics.gains import is_accepted
from master.diagnosis.numerics.least_squares import Fit
from master.diagnosis.replay.placed_effect import PlacedEffect

from .classes import CONVERTER, are_of_a_class, class_of
from .deadline import TimeIsUpError
from .extended_model import ExtendedModel
from .families import (
    NEAR,
    Ranked,
    best_first,
    contains,
    family,
    is_beaten,
    is_confused,
)
from .first_order import FirstOrder
from .screening import Screened, screened, unbuilt
from .study import PRECISE, Study

AT_MOST = 3  # effects
LONGEST_LIST = 6  # effects that are fitted in a round
FEWEST = 1  # effects that are fitted in a round, however little they promise
SMALLEST_PROMISE = 5e-3  # share of the fitted residual power, for a fit
SMALLEST_HELD_OUT = 0.02  # the same on held-out rows, where nothing recorded predicts what is left
SMALLEST_OF_BEST = 0.1  # promise over that of the most promising, for a fit
ENOUGH = 5e-3  # power left over that of the base: a fourteenth of the amplitude
MOST_OF_REST = 0.5  # share of the little that is left then, for one effect more
MOST_BRANCHES = 2  # members of a family between which the next effect may decide
FALLS = 0.01  # of the cost: the effects before were not at their best


@dataclass(frozen=True)
class Round:
    """One round: all that were fitted, best first; the family, winner first; if the next round decided."""

    before: Fit
    ranked: tuple[Ranked, ...]
    family: tuple[Ranked, ...]
    is_resolved: bool = False


@dataclass(frozen=True)
class SearchResult:
    """What a search ends with; `rewritings` are families of an effect and others that equal it together."""

    base: Fit
    model: ExtendedModel
    fit: Fit
    rounds: tuple[Round, ...]
    rewritings: tuple[tuple[str, ...], ...] = ()

    @property
    def families(self) -> list[tuple[str, ...]]:
        """Names of effects that are indistinguishable, one tuple an effect of the model."""
        members = [tuple(r.name for r in rnd.family) for rnd in self.rounds if len(rnd.family) > 1]
        return [*members, *self.rewritings]

    def widened(self, study: Study) -> SearchResult:
        """
        Return the same with wider families, for a residual that still has structure.

        What the best leaves is not noise then, and statistics of noise do not decide between rivals that
        leave nearly as little.
        """
        return replace(self, rounds=tuple(_widened(study, step) for step in self.rounds))


class _Fitted(NamedTuple):
    """A model and its fit."""

    model: ExtendedModel
    fit: Fit


class _Decided(NamedTuple):
    """A round of which the family was narrowed, and the round after its winner."""

    step: Round
    after: Round


class _Branch(NamedTuple):
    """A member of a family, the round after it, and the best of both over the base."""

    member: Ranked
    after: Round
    end: Ranked


def search(
    study: Study,
    base: Fit,
    candidates: Sequence[PlacedEffect],
    at_most: int = AT_MOST,
    is_adequate: Callable[[Fit], bool] = lambda _: False,
    is_noise: Callable[[Fit], bool] = lambda _: False,
    begun: SearchResult | None = None,
) -> SearchResult:
    """
    Add effects one after the other until none is accepted.

    Args:
        study: The part.
        base: Its fit without effects.
        candidates: Effects in their slots.
        at_most: Number of effects.
        is_adequate: Whether nothing that is left can be predicted: no more effects are looked for then, and
            a first one has to promise more, on rows that it has not seen.
        is_noise: Whether no more is left than the noise of the channels: no next effect can decide then
            between those that cannot be told apart.
        begun: A search to go on with, from its last effect.
    """
    so_far = _SoFar(_Fitted(ExtendedModel(), base), [])
    if begun is not None:
        so_far = _SoFar(_Fitted(begun.model, begun.fit), list(begun.rounds))
    try:
        _add(study, base, candidates, at_most, is_adequate, is_noise, so_far)
    except TimeIsUpError:
        study.say("the time is up, the best so far is kept")
    present = so_far.present
    fitted = present.fit
    if present.model.effects:
        fitted = study.fitted(present.model, [present.fit.values], PRECISE)
    return SearchResult(base, present.model, fitted, tuple(so_far.rounds))


@dataclass
class _SoFar:
    """Where a search is: the model with its fit, and the rounds that led to it."""

    present: _Fitted
    rounds: list[Round]


def _add(
    study: Study,
    base: Fit,
    candidates: Sequence[PlacedEffect],
    at_most: int,
    is_adequate: Callable[[Fit], bool],
    is_noise: Callable[[Fit], bool],
    so_far: _SoFar,
) -> None:
    """Do the rounds of a search."""
    rounds = so_far.rounds
    ahead: Round | None = None
    while len(rounds) < at_most:
        present = so_far.present
        is_doubtful = not rounds and is_adequate(base)
        step = ahead or _step(study, present, candidates, is_doubtful=is_doubtful)
        ahead = None
        is_last = len(rounds) + 1 == at_most
        is_open = len(step.family) > 1
        is_over = is_open and is_noise(step.family[0].gain.fit)
        if is_open and not (is_last or is_over or _is_enough(study, base, step.family[0].gain.fit)):
            decided = _looked_ahead(study, base, step, candidates)
            step = decided.step
            ahead = decided.after
        if _is_enough(study, base, present.fit):
            step = _most_of_the_rest(step)
        if step.family and present.model.effects:
            again = study.fitted(present.model, [step.family[0].gain.fit.values], PRECISE)
            if again.cost < (1.0 - FALLS) * present.fit.cost:  # the effects before were not at their best
                so_far.present = _Fitted(present.model.started_at(again.values), again)
                ahead = None
                continue
        rounds.append(step)
        if not step.family:
            break
        winner = step.family[0]
        chosen = winner.model.started_at(winner.gain.fit.values)
        so_far.present = _Fitted(chosen, winner.gain.fit)
        so_far.present = _pruned(study, so_far.present)
        if so_far.present.model.effects != chosen.effects:
            ahead = None
        if is_over or (len(step.family) == 1 and is_adequate(so_far.present.fit)):
            break


def _most_of_the_rest(step: Round) -> Round:
    """
    Accept only what explains most of the little that is left.

    A strong effect's model has faults of its own, and other laws explain parts of them.
    """
    return step if step.family and step.family[0].gain.share > MOST_OF_REST else replace(step, family=())


def _step(
    study: Study, present: _Fitted, candidates: Sequence[PlacedEffect], *, is_doubtful: bool = False
) -> Round:
    """Screen and fit one more effect; it is doubtful where the model before it is adequate."""
    chosen = present.model
    left = [e for e in candidates if e not in chosen.effects]
    study.say(f"{len(left)} effects screened")
    taken = {e.place for e in chosen.effects}
    first_order = FirstOrder(study, chosen, present.fit)
    needed = unbuilt(study, first_order, left)
    study.build([(*chosen.effects, e) if e.place in taken else (e,) for e in needed])
    tried = screened(study, chosen, present.fit, left, first_order=first_order, is_held_out=is_doubtful)
    promising = shortlist([s for s in tried if _is_credible(s)])
    study.build([s.model.effects for s in promising])
    return _round(study, present.fit, promising, len(left))


def _is_credible(s: Screened) -> bool:
    """Whether its promise holds on held-out rows; no regressor sees a converter, so that is always fitted."""
    return not s.held_out < SMALLEST_HELD_OUT or class_of(s.model.effects[-1].law) == CONVERTER


def _looked_ahead(study: Study, base: Fit, step: Round, candidates: Sequence[PlacedEffect]) -> _Decided:
    """Let the next effect decide between the members of a family."""

    def is_inferior(one: Ranked, other: Ranked) -> bool:
        return is_beaten(study, one.gain, other.gain) or contains(study, base, one, other)

    branches = []
    for member in step.family[:MOST_BRANCHES]:
        started = _Fitted(member.model.started_at(member.gain.fit.values), member.gain.fit)
        after = _step(study, started, candidates)
        last = after.family[0] if after.family else member
        branches.append(_Branch(member, after, replace(last, gain=study.gain(base, last.gain.fit))))
    best = branches[0]
    for branch in branches[1:]:
        if is_inferior(best.end, branch.end) and not is_beaten(study, branch.end.gain, best.end.gain):
            best = branch
    inferior = [b.member for b in branches if b.end is not best.end and is_inferior(b.end, best.end)]
    inferior += step.family[MOST_BRANCHES:]
    others = [
        m for m in step.family if m is not best.member and (m not in inferior or is_confused(m, best.member))
    ]
    kept = (best.member, *others)
    return _Decided(replace(step, family=kept, is_resolved=len(kept) == 1), best.after)


def _is_enough(study: Study, base: Fit, fitted: Fit) -> bool:
    """Whether next to nothing is left."""
    return bool(study.powers(fitted.predicted).sum() < ENOUGH * study.powers(base.predicted).sum())


def _pruned(study: Study, present: _Fitted) -> _Fitted:
    """Drop an effect that a later one has made needless."""
    for old in present.model.effects[:-1]:
        less = present.model.without(old)
        study.build([less.effects])
        without = study.fitted(less, [present.fit.values])
        if not is_accepted(study.gain(without, present.fit), 1, is_first=False):
            return _pruned(study, _Fitted(less.started_at(without.values), without))
    return present


def shortlist(tried: Sequence[Screened]) -> list[Screened]:
    """
    The most promising, all members of the class of the best in its slot, and every offset.

    An offset is the simplest law that there is: what it explains alone is due to no other.
    """
    best = tried[0].gain if tried else 0.0
    least = max(SMALLEST_PROMISE, SMALLEST_OF_BEST * best)
    kept = [s for i, s in enumerate(tried[:LONGEST_LIST]) if s.gain >= least or i < FEWEST]
    if not tried or best < SMALLEST_PROMISE:
        return kept
    first = tried[0].model.effects[-1]
    kept += [s for s in tried if s not in kept and are_of_a_class(s.model.effects[-1], first)]
    offsets = [s for s in tried if s.model.effects[-1].law.constant is not None]
    return kept + [s for s in offsets if s not in kept and s.gain >= SMALLEST_PROMISE]


def _round(study: Study, before: Fit, promising: Sequence[Screened], n_tried: int) -> Round:
    is_first = all(len(s.model.effects) == 1 for s in promising)
    ranked = []
    for s in promising:
        study.say(f"fit of {s.model.name}")
        fitted = study.fitted(s.model, s.starts, known=s.known)
        ranked.append(Ranked(s.model, study.gain(before, fitted)))
    accepted = [r for r in best_first(ranked) if is_accepted(r.gain, n_tried, is_first=is_first)]
    refined = [_refined(study, before, r) for r in family(study, before, accepted)]
    others = [r for r in ranked if r.name not in {own.name for own in refined}]
    kept = family(study, before, best_first(refined))
    return Round(before, tuple(best_first([*others, *refined])), tuple(kept))


def _refined(study: Study, before: Fit, r: Ranked) -> Ranked:
    """Fit a member of a family to the end: what a first fit leaves would pass for another effect."""
    fitted = study.fitted(r.model, [r.gain.fit.values], PRECISE)
    return replace(r, gain=study.gain(before, fitted)) if fitted.cost < r.gain.fit.cost else r


def _widened(study: Study, step: Round) -> Round:
    if not step.family or step.is_resolved:
        return step
    winner = step.family[0]
    near = [r for r in step.ranked if r.gain.is_accepted and winner.gain.mean - r.gain.mean < NEAR]
    others = [r for r in near if r not in step.family and not contains(study, step.before, r, winner)]
    return replace(step, family=(*step.family, *others))

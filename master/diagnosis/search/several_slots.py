"""
One law in several slots at once: what one outlet lacks, the next of its make lacks too.

In one slot alone such a law may explain little, or another explains as much there: the next slot still
contradicts it, and a search that adds one effect after the other does not get there. So slots of a kind
are filled together, each with numbers of its own, and the search goes on from there. Slots of one FMU are of
a kind if they have the same unit and signals of the same units, and no rate: laws of the position alone.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from fmu_sources.effects.framework.roles import roles, units
from fmu_sources.framework.model import Slot
from master.diagnosis.numerics.arrays import Array
from master.diagnosis.numerics.gains import is_accepted
from master.diagnosis.numerics.least_squares import Fit, FreeParameter
from master.diagnosis.replay.placed_effect import PlacedEffect, fixed_values, free_parameters

from .extended_model import ExtendedModel
from .families import Ranked, best_first
from .rounds import SMALLEST_PROMISE, Round, SearchResult, search
from .screening import FACTORS, LEAST_AMPLITUDE
from .study import PRECISE, Study
from .tangent import Tangent

Together = tuple[PlacedEffect, ...]
"""One law in several slots."""

MOST_ROUNDS = 2  # laws in several slots, one after the other
MOST_FITTED = 3  # laws, of those that promise most
SMALLEST_OF_BEST = 0.5  # promise over that of the most promising, for a fit


@dataclass(frozen=True)
class _Promise:
    """
    A law in several slots: the share of the residual's power that one linear step takes away.

    `starts` are first guesses, one for each size of the shapes.
    """

    share: float
    model: ExtendedModel
    starts: tuple[Mapping[str, float], ...]


def with_laws_in_several_slots(
    study: Study,
    result: SearchResult,
    candidates: Sequence[PlacedEffect],
    is_adequate: Callable[[Fit], bool],
    is_noise: Callable[[Fit], bool] = lambda _: False,
) -> SearchResult:
    """
    Search again from the best law in several slots at once, and keep what ends better.

    Args:
        study: The part.
        result: What a search that adds one effect after the other ended with.
        candidates: Effects in their slots.
        is_adequate: See `search`; nothing is tried where the result is adequate.
        is_noise: See `search`.

    The results of the two searches are compared once, by the power that they leave on the held-out blocks and
    what chance makes of it, as an effect is compared with the model before it. A comparison block by block
    would not do: neither contains the other, so one may be right in a single block by accident, whose
    logarithm outweighs all others.
    """
    laws = together(study, candidates)
    if not laws or is_adequate(result.fit):
        return result
    study.say(f"{len(laws)} laws in several slots at once")
    begun = SearchResult(result.base, ExtendedModel(), result.base, ())
    for _ in range(MOST_ROUNDS):
        further = _with_one_more(study, begun, laws)
        if further is None:
            break
        begun = further
    if not begun.rounds:
        return result
    found = begun
    if not is_adequate(begun.fit):
        found = search(
            study, result.base, candidates, is_adequate=is_adequate, is_noise=is_noise, begun=begun
        )
    return found if is_accepted(study.gain(result.fit, found.fit), 1) else result


def together(study: Study, candidates: Sequence[PlacedEffect]) -> list[Together]:
    """List the laws of the position that may be in all slots of a kind."""
    found = []
    for places in _slots_of_a_kind(study, candidates):
        for name in sorted({e.effect for e in candidates}):
            own = tuple(e for e in candidates if e.effect == name and e.place in places)
            if len(own) == len(places) and own[0].law.needs:
                found.append(own)
    return found


def _slots_of_a_kind(study: Study, candidates: Sequence[PlacedEffect]) -> list[list[str]]:
    """Groups of slots `fmu.slot` of a kind, of two at least."""

    def kind(slot: Slot) -> tuple[object, ...]:
        return (slot.unit, sorted(roles(slot)), sorted(units(slot).items()))

    groups = []
    for fmu in dict.fromkeys(e.fmu for e in candidates):
        used = {e.slot for e in candidates if e.fmu == fmu}
        slots = [
            s for s in study.system.slots(fmu).values() if s.name in used and set(roles(s)) == {"position"}
        ]
        for _, same in itertools.groupby(
            sorted(slots, key=lambda s: str(kind(s))), key=lambda s: str(kind(s))
        ):
            places = [f"{fmu}.{s.name}" for s in same]
            if len(places) > 1:
                groups.append(places)
    return groups


def _with_one_more(study: Study, so_far: SearchResult, laws: Sequence[Together]) -> SearchResult | None:
    """Add the law that does best in several slots at once; None if none is worth it."""
    tangent = Tangent(study, so_far.model, so_far.fit)
    left = [law for law in laws if not set(law) & set(so_far.model.effects)]
    study.build([(*so_far.model.effects, placed) for law in left for placed in law])
    best_of: dict[Together, _Promise] = {}
    for p in (p for law in left for p in _promises(study, tangent, law)):
        if np.isfinite(p.share):
            other = best_of.get(p.model.effects, p)
            best = max(p, other, key=lambda q: q.share)
            starts = p.starts if other is p else (*other.starts, *p.starts)
            best_of[p.model.effects] = replace(best, starts=starts)
    ordered = sorted(best_of.values(), key=lambda p: -p.share)
    least = max(SMALLEST_PROMISE, SMALLEST_OF_BEST * ordered[0].share) if ordered else 0.0
    shortlist = [p for p in ordered[:MOST_FITTED] if p.share >= least]
    study.build([p.model.effects for p in shortlist])
    ranked = []
    for p in shortlist:
        study.say(f"fit of {' and '.join(map(str, p.model.effects))}")
        fitted = _fitted(study, so_far, p)
        ranked.append(Ranked(p.model, study.gain(so_far.fit, fitted)))
    is_first = not so_far.rounds
    accepted = [r for r in ranked if is_accepted(r.gain, len(left), is_first=is_first)]
    if not accepted:
        return None
    winner = max(accepted, key=lambda r: r.gain.share)
    fitted = winner.gain.fit
    step = Round(so_far.fit, tuple(best_first(ranked)), (winner,))
    model = winner.model.started_at(fitted.values)
    return SearchResult(so_far.base, model, fitted, (*so_far.rounds, step))


def _fitted(study: Study, so_far: SearchResult, promise: _Promise) -> Fit:
    """
    Fit from the model before it, and from the base where that has effects.

    What laws were bent to alone is no good place to begin from with what they lacked.
    """
    begins = [dict(so_far.fit.values)]
    if so_far.model.effects:
        typical = {
            p.name: p.start
            for placed in so_far.model.effects
            for p in free_parameters(placed, study.signal_rms(placed.place))
        }
        begins.append(dict(so_far.base.values) | typical)
    guesses = [begin | dict(start) for begin in begins for start in promise.starts]
    fits = [study.fitted(promise.model, [guess]) for guess in guesses]  # a few steps do not tell minima apart
    best = min(fits, key=lambda f: f.cost)
    return study.fitted(promise.model, [best.values], PRECISE)


def _promises(study: Study, tangent: Tangent, law: Together) -> Iterator[_Promise]:
    """One linear step at each size of the shapes, the same over their scale in every slot."""
    for factor in FACTORS:
        for variant in law[0].law.variants:
            before = tangent.chosen.started_at(tangent.fit.values)
            model = before
            start: dict[str, float] = {}
            probed: list[FreeParameter] = []
            answers: list[Array] = []
            for placed in law:
                rms = study.signal_rms(placed.place)
                own = free_parameters(placed, rms)
                fixed = fixed_values(placed, rms, variant)
                alone = before.with_effect(placed, fixed, own)
                model = model.with_effect(placed, fixed, own)
                amplitudes = [p for p in own if placed.short_name(p.name) in placed.law.amplitudes]
                shapes = {p.name: _bounded(factor * p.start, p) for p in own if p not in amplitudes}
                absent = {p.name: 0.0 for p in amplitudes}
                for p in amplitudes:
                    probe = {p.name: placed.law.probe * p.start}
                    answers.append(tangent.response(alone, shapes | absent | probe))
                probed += amplitudes
                start |= shapes
            if not probed:
                continue
            gain = tangent.gain(answers, [0.0 if p.low >= 0.0 else -np.inf for p in probed])
            for p, size in zip(probed, gain.factors, strict=True):
                least = LEAST_AMPLITUDE * p.start if p.low >= 0.0 else p.low
                start[p.name] = float(min(max(size * law[0].law.probe * p.start, least), p.high))
            yield _Promise(gain.share, model, (start,))


def _bounded(value: float, p: FreeParameter) -> float:
    return float(min(max(value, p.low), p.high))

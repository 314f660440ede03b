"""One law or two: what the library has as one effect may be two others at once."""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Sequence
from dataclasses import replace

from master.diagnosis.replay.candidate_models import Added, fixed_values, parameters

from .families import is_beaten
from .rounds import Found, Round
from .study import Extended, Study

AND = " and "


def with_rewritings(study: Study, found: Found, wanted: Sequence[Added]) -> Found:
    """
    Put others in the place of an effect that is `equals_sum_of` them, where they explain more.

    Where they explain as much, the effect and they are a family.
    """
    for step in found.rounds:
        for member in step.family:
            for parts in _parts(member.extended.added[-1], wanted, found.extended.added):
                study.progress(f"{study.bench.part.name}: {AND.join(map(str, parts))} in its place")
                found = _decided(study, found, step, parts)
    return found


def _decided(study: Study, found: Found, step: Round, parts: Sequence[Added]) -> Found:
    old = step.family[0].extended.added[-1]
    if old not in found.extended.added:
        return found
    other = _instead(study, found.extended, old, parts)
    study.pool.build([other.added], study.progress)
    fitted = study.fitted(other, [found.fit.values], 30, 1e-8)
    one, two = (study.gain(found.base, f) for f in (found.fit, fitted))
    if is_beaten(study, two, one):
        return found
    if is_beaten(study, one, two):
        rounds = tuple(replace(r, family=r.family[:1]) if r is step else r for r in found.rounds)
        return replace(found, extended=other.started_at(fitted.values), fit=fitted, rounds=rounds)
    return replace(found, rewritings=(*found.rewritings, (str(old), AND.join(map(str, parts)))))


def _parts(law: Added, wanted: Sequence[Added], taken: Sequence[Added]) -> Iterator[tuple[Added, ...]]:
    """All ways to place what a law is made of; the first of it stands where the law stood."""
    places = [[a for a in wanted if a.effect == name and a not in taken] for name in law.law.equals_sum_of]
    if places:
        places[0] = [a for a in places[0] if (a.fmu, a.slot) == (law.fmu, law.slot)]
        yield from itertools.product(*places)


def _instead(study: Study, chosen: Extended, old: Added, parts: Sequence[Added]) -> Extended:
    begin = f"{old.fmu}.{old.prefix}_"
    fixed = {k: v for k, v in chosen.fixed.items() if not k.startswith(begin)}
    own = [p for p in chosen.parameters if not p.name.startswith(begin)]
    for a in parts:
        sizes = study.sizes(f"{a.fmu}.{a.slot}")
        fixed |= fixed_values(a, sizes, a.law.variants[0])
        own += parameters(a, sizes)
    return Extended((*(a for a in chosen.added if a != old), *parts), fixed, tuple(own))

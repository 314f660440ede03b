"""
Forward search: screen, fit the promising, rank on held-out blocks, keep the simplest that is not beaten.

Of effects that cannot be told apart, one with more parameters is dropped if it predicts the same as one
with fewer: it contains the other and is no rival. What then remains beside the best is its family; the next
effect may decide in it. Lag, delay, carried mass and mount resonance of one signal differ in higher orders
alone, where models are wrong too: they stay a family as long as they explain nearly as much.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy import stats

from .fitting import Fit
from .ranking import ERRORS, SMALLEST_GAIN, Gain, powers
from .screening import Screened, screened
from .study import Extended, Study
from .tables import Array
from .variants import Added

AT_MOST = 3
PRECISELY = (60, 1e-8)  # evaluations, tolerance
LONGEST_LIST, FEWEST, SMALLEST_PROMISE = 6, 1, 5e-3
SAME_PREDICTION = 0.1
ALPHA = 0.05
ENOUGH = 5e-3
MOST_BRANCHES = 2
NEAR, CLEAR = 0.18, 3.0  # 20 % of what is left; standard errors
LAG_LIKE = {"extra_lag", "extra_delay", "end_effector_inertia", "mount_resonance"}
CONFUSED_SHARE = 0.8


@dataclass(frozen=True)
class Ranked:
    """An effect that was fitted, with its gain over the model before it."""

    extended: Extended
    gain: Gain

    @property
    def name(self) -> str:
        """`fmu.slot: effect`."""
        return self.extended.name

    @property
    def n_parameters(self) -> int:
        """Number of fitted parameters of all effects."""
        return len(self.extended.parameters)


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
    """Add effects one after the other until none is accepted, or little is left of the residual."""
    chosen, found = Extended(), base
    rounds: list[Round] = []
    ahead: Round | None = None
    while len(rounds) < at_most:
        step = ahead or _step(study, chosen, found, wanted)
        ahead = None
        is_last = len(rounds) + 1 == at_most
        if len(step.family) > 1 and not is_last and not _is_enough(study, base, step.family[0].gain.fit):
            step, ahead = _looked_ahead(study, base, step, wanted)
        rounds.append(step)
        if not step.family:
            break
        winner = step.family[0]
        chosen, found = winner.extended.started_at(winner.gain.fit.values), winner.gain.fit
        if _is_enough(study, base, found):
            break
        pruned, found = _pruned(study, chosen, found)
        if pruned.added != chosen.added:
            chosen, ahead = pruned, None
    if chosen.added:
        found = study.fitted(chosen, [found.values], *PRECISELY)
    return Found(base, chosen, found, tuple(rounds))


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
    branches = []
    for member in step.family[:MOST_BRANCHES]:
        after = _step(study, member.extended.started_at(member.gain.fit.values), member.gain.fit, wanted)
        last = after.family[0].gain.fit if after.family else member.gain.fit
        branches.append((study.gain(base, last), member, after))
    best = branches[0]
    for branch in branches[1:]:
        if is_beaten(study, best[0], branch[0]):
            best = branch
    beaten = [m for total, m, _ in branches if total is not best[0] and is_beaten(study, total, best[0])]
    beaten += step.family[MOST_BRANCHES:]
    others = [m for m in step.family if m is not best[1] and (m not in beaten or _is_confused(m, best[1]))]
    family = [best[1], *others]
    return replace(step, family=tuple(family), is_resolved=len(family) == 1), best[2]


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
    best = tried[0].gain if tried else 0.0
    least = max(SMALLEST_PROMISE, 0.1 * best)
    return [s for i, s in enumerate(tried[:LONGEST_LIST]) if s.gain >= least or i < FEWEST]


def _round(study: Study, before: Fit, promising: Sequence[Screened], n_tried: int) -> Round:
    is_first = all(len(s.extended.added) == 1 for s in promising)
    ranked = []
    for s in promising:
        study.progress(f"{study.bench.part.name}: fit of {s.extended.name}")
        found = study.fitted(s.extended, s.starts, known=s.known)
        ranked.append(Ranked(s.extended, study.gain(before, found)))
    accepted = [r for r in _best_first(ranked) if is_accepted(r.gain, n_tried, is_first=is_first)]
    refined = [_refined(study, before, r) for r in _family(study, before, accepted)]
    others = [r for r in ranked if r.name not in {own.name for own in refined}]
    family = _family(study, before, _best_first(refined))
    return Round(before, tuple(_best_first([*others, *refined])), tuple(family))


def _best_first(ranked: Sequence[Ranked]) -> list[Ranked]:
    return sorted(ranked, key=lambda r: -r.gain.mean)


def _refined(study: Study, before: Fit, r: Ranked) -> Ranked:
    """Fit a member of a family to the end: what a first fit leaves would pass for another effect."""
    found = study.fitted(r.extended, [r.gain.fit.values], *PRECISELY)
    return replace(r, gain=study.gain(before, found)) if found.cost < r.gain.fit.cost else r


def is_accepted(found: Gain, n_tried: int, *, is_first: bool = True) -> bool:
    """
    Whether a gain is worth it and not the luckiest of many tries (t-test, Bonferroni over the tries).

    The first effect competes with chance. Later ones and what stands beside names compete with the faults
    of the models before them, too: all blocks have to gain about alike.
    """
    n = len(found.by_block)
    z = found.z if is_first else found.mean / max(found.error, 1e-300)
    is_clear = z > ERRORS and bool(stats.t.sf(z, n - 1) * n_tried < ALPHA)
    return found.mean > SMALLEST_GAIN and is_clear


def _family(study: Study, before: Fit, accepted: Sequence[Ranked]) -> list[Ranked]:
    """The winner and what cannot be told from it."""
    if not accepted:
        return []
    best = accepted[0]
    rivals = [
        r for r in accepted if r is best or _is_confused(r, best) or not is_beaten(study, r.gain, best.gain)
    ]
    rivals.sort(key=lambda r: (r.n_parameters, -r.gain.mean))
    kept: list[Ranked] = []
    for r in rivals:
        if not any(k.n_parameters < r.n_parameters and _same(study, before, k, r) for k in kept):
            kept.append(r)
    return sorted(kept, key=lambda r: -r.gain.mean)


def _is_confused(one: Ranked, best: Ranked) -> bool:
    """Whether both are lag-like in one slot and explain nearly as much."""
    a, b = one.extended.added[-1], best.extended.added[-1]
    is_alike = (a.fmu, a.slot) == (b.fmu, b.slot) and {a.effect, b.effect} <= LAG_LIKE
    return is_alike and one.gain.share > CONFUSED_SHARE * best.gain.share


def _widened(study: Study, step: Round) -> Round:
    if not step.family or step.is_resolved:
        return step
    winner = step.family[0]
    near = [r for r in step.ranked if r.gain.is_accepted and winner.gain.mean - r.gain.mean < NEAR]
    others = [
        r
        for r in near
        if r not in step.family
        and not (r.n_parameters > winner.n_parameters and _same(study, step.before, winner, r))
    ]
    return replace(step, family=(*step.family, *others))


def is_worse(one: Gain, best: Gain) -> bool:
    """Whether a gain is smaller block by block, by more than 1 % and two standard errors."""
    difference = best.by_block - one.by_block
    error = difference.std(ddof=1) / np.sqrt(len(difference))
    return bool(difference.mean() > max(SMALLEST_GAIN, 2.0 * error))


def is_beaten(study: Study, one: Gain, best: Gain) -> bool:
    """
    Whether a gain is smaller block by block, or a fifth more is left, by more than chance makes of it.

    The second sees what happens in few blocks, where a mean over the blocks is uncertain.
    """
    if is_worse(one, best):
        return True
    more = study.gain(one.fit, best.fit)
    return more.mean > NEAR and more.z > CLEAR


def _same(study: Study, before: Fit, one: Ranked, other: Ranked) -> bool:
    apart = _rms(study, one.gain.fit.predicted - other.gain.fit.predicted)
    return apart < SAME_PREDICTION * _rms(study, one.gain.fit.predicted - before.predicted)


def _rms(study: Study, values: Array) -> float:
    rows = np.concatenate([np.arange(s.start, s.stop) for s in study.held_out])
    return float(np.sqrt(np.nanmean((values / study.size)[rows] ** 2)))

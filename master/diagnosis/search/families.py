"""
The winner of a round and what cannot be told from it: its family.

Of effects that cannot be told apart, one with more parameters is dropped if it predicts the same as one
with fewer: it contains the other and is no rival. Lag, delay, carried mass and mount resonance of one signal
differ in higher orders alone, where models are wrong too: they stay a family as long as they explain nearly
as much.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy import stats

from master.diagnosis.numerics.arrays import Array
from master.diagnosis.numerics.gains import ERRORS, SMALLEST_GAIN, Gain
from master.diagnosis.numerics.least_squares import Fit

from .study import Extended, Study

SAME_PREDICTION = 0.1
ALPHA = 0.05
NEAR, CLEAR = 0.18, 3.0  # 20 % of what is left; standard errors
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


def best_first(ranked: Sequence[Ranked]) -> list[Ranked]:
    """Sort by the mean gain."""
    return sorted(ranked, key=lambda r: -r.gain.mean)


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


def family(study: Study, before: Fit, accepted: Sequence[Ranked]) -> list[Ranked]:
    """The winner and what cannot be told from it."""
    if not accepted:
        return []
    best = _winner(study, accepted)
    rivals = [
        r for r in accepted if r is best or is_confused(r, best) or not is_beaten(study, r.gain, best.gain)
    ]
    rivals.sort(key=lambda r: (r.n_parameters, -r.gain.mean))
    kept: list[Ranked] = []
    for r in rivals:
        if is_confused(r, best) or not any(contains(study, before, r, k) for k in kept):
            kept.append(r)
    return sorted(kept, key=lambda r: (r is not best, -r.gain.mean))


def _winner(study: Study, accepted: Sequence[Ranked]) -> Ranked:
    """The best over the blocks, unless another beats it in few of them."""
    best = accepted[0]
    for r in accepted[1:]:
        if is_beaten(study, best.gain, r.gain) and not is_beaten(study, r.gain, best.gain):
            best = r
    return best


def is_confused(one: Ranked, best: Ranked) -> bool:
    """Whether both act alike in one slot and explain nearly as much."""
    return act_alike(one.extended, best.extended) and one.gain.share > CONFUSED_SHARE * best.gain.share


def act_alike(one: Extended, other: Extended) -> bool:
    """Whether the last effects of both act like a lag, say, in one slot."""
    a, b = one.added[-1], other.added[-1]
    return (a.fmu, a.slot) == (b.fmu, b.slot) and a.law.acts_like == b.law.acts_like is not None


def contains(study: Study, before: Fit, large: Ranked, small: Ranked) -> bool:
    """Whether the one with more parameters predicts what the other predicts."""
    return large.n_parameters > small.n_parameters and _same(study, before, small, large)


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
    return max(more.mean, more.share) > NEAR and more.z > CLEAR


def _same(study: Study, before: Fit, one: Ranked, other: Ranked) -> bool:
    apart = _rms(study, one.gain.fit.predicted - other.gain.fit.predicted)
    return apart < SAME_PREDICTION * _rms(study, one.gain.fit.predicted - before.predicted)


def _rms(study: Study, values: Array) -> float:
    rows = np.concatenate([np.arange(s.start, s.stop) for s in study.held_out])
    return float(np.sqrt(np.nanmean((values / study.size)[rows] ** 2)))

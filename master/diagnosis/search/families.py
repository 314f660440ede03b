"""
The winner of a round and what is indistinguishable from it: its family.

Of effects that are indistinguishable, one with more parameters is dropped if it predicts the same as one
with fewer: it contains the other and is no rival. Lag, delay, carried mass and mount resonance of one signal
differ in higher orders alone, where models are wrong too: they stay a family as long as they explain nearly
as much.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from master.diagnosis.numerics.arrays import Array
from master.diagnosis.numerics.gains import Gain, is_worse
from master.diagnosis.numerics.least_squares import Fit

from .extended_model import ExtendedModel
from .study import Study

SAME_PREDICTION = 0.1  # rms of the difference over that of the change: two models that predict the same
NEAR = 0.18  # gain: ln of 1.2, a fifth more is left
CLEAR = 3.0  # standard errors
CONFUSED_SHARE = 0.8  # share of the best's: a lag-like effect that explains as much


@dataclass(frozen=True)
class Ranked:
    """An effect that was fitted, with its gain over the model before it."""

    model: ExtendedModel
    gain: Gain

    @property
    def name(self) -> str:
        """`fmu.slot: effect`."""
        return self.model.name

    @property
    def n_parameters(self) -> int:
        """Number of fitted parameters of all effects."""
        return len(self.model.parameters)


def best_first(ranked: Sequence[Ranked]) -> list[Ranked]:
    """Sort by the mean gain."""
    return sorted(ranked, key=lambda r: -r.gain.mean)


def family(study: Study, before: Fit, accepted: Sequence[Ranked]) -> list[Ranked]:
    """Return the winner and what is indistinguishable from it."""
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
    return act_alike(one.model, best.model) and one.gain.share > CONFUSED_SHARE * best.gain.share


def act_alike(one: ExtendedModel, other: ExtendedModel) -> bool:
    """Whether the last effects of both act like a lag, say, in one slot."""
    a = one.effects[-1]
    b = other.effects[-1]
    return a.place == b.place and a.law.acts_like == b.law.acts_like is not None


def contains(study: Study, before: Fit, large: Ranked, small: Ranked) -> bool:
    """Whether the one with more parameters predicts what the other predicts."""
    return large.n_parameters > small.n_parameters and _same(study, before, small, large)


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
    return float(np.sqrt(np.nanmean((values / study.output_scale)[rows] ** 2)))

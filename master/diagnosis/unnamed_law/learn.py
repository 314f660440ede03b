"""
A law without a name: what no listed effect explains, learned in one of the slots.

All laws that the slots can have are regressed on the residual beside what is fitted already, with a penalty
on their roughness. Those that predict the held-out blocks best become models of their own, and are fitted by
steps of Gauss-Newton over true replays.

Source: Eilers, Marx, Statistical Science 11 (1996) 89 (penalised splines).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from fmu_sources.effects.learned import CENTRES, N_SPLINES, axes
from master.diagnosis.numerics.arrays import Array
from master.diagnosis.numerics.gains import SMALLEST_GAIN, Gain, powers
from master.diagnosis.numerics.least_squares import Fit, bounded
from master.diagnosis.replay.candidate_models import Added, parameters
from master.diagnosis.search.injection import Injection
from master.diagnosis.search.study import Extended, Study

from .fit import Descent, Promise, prior_of, roughness, sensitivities, solved
from .shapes import Law, laws

PENALTIES = (1e-4, 1e-2, 1.0, 100.0)
LOOSER, BETTER = 1e-2, 0.01
N_FITTED, NEAR = 3, 0.2


@dataclass(frozen=True)
class Learned:
    """A learned law in a slot: the fit, its gain over the model without it, how many laws were tried."""

    extended: Extended
    gain: Gain
    promise: Promise
    n_tried: int

    @property
    def shape(self) -> str:
        """The law in words."""
        return describe(self.extended.added[-1], self.fit)

    @property
    def fit(self) -> Fit:
        """The fit of base and effects."""
        return self.gain.fit


def learn(
    study: Study, chosen: Extended, found: Fit, slots: Sequence[str], over: Fit | None = None
) -> Learned | None:
    """
    Fit the learned law that explains most beside the effects chosen; None if none promises anything.

    It starts from the model with the parameters `found`; its gain is that over the fit `over`, else `found`.
    """
    groups = laws(study, slots)
    if not groups:
        return None
    study.progress(f"{study.bench.part.name}: {len(groups)} laws without a name tried")
    over = over or found
    promising = _promising(study, chosen, (found, over), groups)
    study.pool.build([(*chosen.added, p.law.added) for p in promising], study.progress)
    n_tried = sum(map(len, groups))
    fitted = [_fitted(study, chosen, (found, over), p, n_tried) for p in promising]
    return max(fitted, key=lambda f: f.gain.mean, default=None)


def relearned(study: Study, law: Learned, found: Fit) -> Fit:
    """Fit a law once more, on the rows of another study."""
    return Descent(study, law.extended, law.promise).fit(found)


def _fitted(study: Study, chosen: Extended, fits: tuple[Fit, Fit], promise: Promise, n_tried: int) -> Learned:
    """Fit one law, and let it be rougher for as long as that pays on the held-out blocks."""
    found, over = fits
    extended = _extended(study, chosen, found, promise.law)
    best: Learned | None = None
    while True:
        fitted = Descent(study, extended, promise).fit(found if best is None else best.fit)
        own = Learned(extended, study.gain(over, fitted), promise, n_tried)
        if best is not None and own.gain.mean < best.gain.mean + BETTER:
            return best
        best = own
        if promise.penalty < PENALTIES[0]:
            return best
        promise = replace(promise, penalty=LOOSER * promise.penalty)


def _promising(
    study: Study, chosen: Extended, fits: tuple[Fit, Fit], groups: Sequence[Sequence[Law]]
) -> list[Promise]:
    """The laws that predict the held-out blocks best by one linear step, each with its best penalty."""
    values = dict(chosen.fixed) | dict(fits[0].values)
    regression = _Regression(study, chosen, fits)
    injections: dict[str, Injection] = {}
    best = []
    for group in groups:
        promises: list[Promise] = []
        for law in group:
            slot = f"{law.added.fmu}.{law.added.slot}"
            if slot not in injections:
                base = {p.name: values[p.name] for p in study.base}
                injections[slot] = Injection(study, slot, base)
            at = injections[slot]
            if at.is_linear:
                columns = at.answer(law.functions(study, study.signals[slot]))
                promises += [Promise(law, p, g, at) for p, g in regression.gains(law, columns)]
        if promises:
            best.append(max(promises, key=lambda p: p.gain))
    best = sorted((p for p in best if p.gain > SMALLEST_GAIN), key=lambda p: -p.gain)
    return [p for p in best[:N_FITTED] if p.gain > (1.0 - NEAR) * best[0].gain or p is best[0]]


class _Regression:
    """The residual of a fit regressed on a law's answers beside the sensitivities of what is fitted."""

    def __init__(self, study: Study, chosen: Extended, fits: tuple[Fit, Fit]) -> None:
        self.study, (found, over) = study, fits
        self.left = bounded((study.measured - found.predicted) / study.size)
        self.before = powers(over.predicted - study.measured, study.held_out, study.size)
        self.own = sensitivities(study, chosen, found)
        self.prior = prior_of(study, chosen)
        self.starts = np.array(
            [p.start - found.values[p.name] for p in (*study.base, *chosen.parameters)]
        ) / np.array([p.scale for p in (*study.base, *chosen.parameters)])

    def gains(self, law: Law, columns: Array) -> list[tuple[float, float]]:
        """Penalty and mean gain on the held-out blocks."""
        matrix = np.concatenate([self.own, columns], axis=2)
        found = []
        for penalty in PENALTIES:
            below = roughness(law, self.own.shape[2], columns[self.study.fit_rows], penalty, self.prior)
            target = np.concatenate([self.starts, np.zeros(len(law.names))])
            step = solved(matrix[self.study.fit_rows], self.left[self.study.fit_rows], below, target)
            rest = (self.left - matrix @ step) * self.study.size
            power = powers(rest, self.study.held_out, self.study.size)
            found.append((penalty, float(np.mean(np.log(self.before / power)))))
        return found


def _extended(study: Study, chosen: Extended, found: Fit, law: Law) -> Extended:
    sizes = study.sizes(f"{law.added.fmu}.{law.added.slot}")
    own = tuple(
        replace(p, start=0.0, low=-np.inf, high=np.inf)
        for p in parameters(law.added, sizes)
        if p.name in law.names
    )
    return Extended(
        (*chosen.added, law.added),
        dict(chosen.fixed) | dict(law.fixed),
        (*chosen.parameters, *own),
    )


def describe(added: Added, found: Fit) -> str:
    """Say which signals, odd or even, memory or not."""
    first, second = axes(added.effect)
    c, d = halves(added, found)
    place = f"{added.fmu}.{added.slot}"
    if first == "plays":
        return f"a law with memory of the position in {place}"
    signals = first if np.sum(d**2) < 0.01 * np.sum(c**2) else f"{first} and {second}"
    signals = signals.replace("memory", "rate of the value").replace("sign", "direction of motion")
    if first in ("time", "cycle"):
        kind = "that swings with a period" if first == "cycle" else "that changes with time"
        return f"a law {kind}, of {signals}, in {place}"
    odd = 0.5 * (c - c[::-1])
    share = float(np.sum(odd**2) / max(np.sum(c**2), 1e-300))
    kind = "odd" if share > 0.8 else "even" if share < 0.2 else "neither odd nor even"
    return f"a smooth law of {signals} in {place}, {kind}, without memory"


def halves(added: Added, found: Fit) -> tuple[Array, Array]:
    """Coefficients c_i and d_i."""
    begin = f"{added.fmu}.{added.prefix}_"
    own = {k.removeprefix(begin): v for k, v in found.values.items() if k.startswith(begin)}
    c, d = ([v for k, v in own.items() if k.startswith(letter + "_")] for letter in "cd")
    return np.array(c), np.array(d)


def coefficients(added: Added, found: Fit) -> Array:
    """The law over its two axes, each from -1 to 1 of its half range, shape (functions, 21)."""
    c, d = halves(added, found)
    return np.asarray(c[:, None] + d[:, None] * np.clip(np.array(CENTRES), -1.0, 1.0)[None, :N_SPLINES])

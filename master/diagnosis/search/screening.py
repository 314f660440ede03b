"""
Which effects are worth a fit: one step of Gauss-Newton for each, at a few shapes.

The residual is regressed on the response of the outputs to the effect, together with the sensitivities of
what is fitted already. What a law is linear in are amplitudes, the regression gives their size: parameters in
units of the slot's value, and those that are zero without the effect. The others are shapes and are tried.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from fmu_sources.effects.framework.effect import FirstGuess
from master.diagnosis.numerics.arrays import Array
from master.diagnosis.numerics.least_squares import Fit, FreeParameter, bounded
from master.diagnosis.numerics.periods import likely_frequencies, likely_periods
from master.diagnosis.numerics.quanta import likely_steps
from master.diagnosis.replay.placed_effect import PlacedEffect, fixed_values, free_parameters

from .extended_model import ExtendedModel
from .first_order import FirstOrder
from .injection import Injection
from .study import Study
from .tangent import Tangent

FACTORS = (0.1, 0.3, 1.0, 3.0)  # sizes of a shape that are tried, over its typical one
FACTORS_OF_TIME = (0.1, 0.3, 0.6, 0.9, 1.2, 1.6, 2.2, 3.0)  # a delay of held values has several minima
FACTORS_OF_FREQUENCY = (0.1, 0.2, 0.4, 0.6, 1.0, 1.6, 2.5, 4.0)  # a resonance is seen from nearby only
LEAST_AMPLITUDE = 1e-2  # of the typical size, where a fit starts
N_STARTS = 4
NEAR_BEST = 0.5  # of the best's share: what a shape has to promise for a fit to start there
RATE = "{value}/{position}"
SAME = 0.999  # correlation of an output that is the slot's value


@dataclass(frozen=True)
class Screened:
    """
    An effect with first guesses; `gain` is the share of the fitted residual power that it promises.

    `held_out` is the share that this promise keeps on the held-out rows, NaN where it was not asked for.
    `known` are the sensitivities to what is fitted already, before the effect, for the first steps of a fit.
    """

    model: ExtendedModel
    starts: tuple[Mapping[str, float], ...]
    gain: float
    known: Mapping[str, Array]
    held_out: float = np.nan


@dataclass(frozen=True)
class _Trial:
    """One variant and shape of an effect: the share that it promises, and where a fit would start."""

    share: float
    model: ExtendedModel
    start: Mapping[str, float]


def screened(
    study: Study,
    chosen: ExtendedModel,
    fitted: Fit,
    candidates: Sequence[PlacedEffect],
    *,
    first_order: FirstOrder | None = None,
    is_held_out: bool = False,
) -> list[Screened]:
    """
    Try all effects on the model so far, best first; on request, ask what holds on rows held out.

    Effects that `first_order` covers need not be built.
    """
    tangent = Tangent(study, chosen, fitted, first_order)
    tried = [_best(study, tangent, placed) for placed in candidates]
    found = sorted((s for s in tried if s is not None), key=lambda s: -s.gain)
    if not is_held_out:
        return found
    return [replace(s, held_out=tangent.held_out_share(s.model, s.starts[0])) for s in found]


def unbuilt(study: Study, first_order: FirstOrder, candidates: Sequence[PlacedEffect]) -> list[PlacedEffect]:
    """Effects that have to be built to be screened."""
    return [e for e in candidates if not first_order.covers(e, _typical(study, e))]


def _typical(study: Study, placed: PlacedEffect) -> dict[str, float]:
    """Values of an effect at its typical size, by `fmu.variable`."""
    rms = study.signal_rms(placed.place)
    own = {p.name: p.start for p in free_parameters(placed, rms)}
    return own | fixed_values(placed, rms, placed.law.variants[0])


def _best(study: Study, tangent: Tangent, placed: PlacedEffect) -> Screened | None:
    """The best shape and side of one effect."""
    rms = study.signal_rms(placed.place)
    trials = []
    for variant in placed.law.variants:
        own = free_parameters(placed, rms)
        model = tangent.chosen.started_at(tangent.fit.values).with_effect(
            placed, fixed_values(placed, rms, variant), own
        )
        trials += [_trial(tangent, model, shape) for shape in _shapes(study, tangent, placed, own)]
    trials = sorted((t for t in trials if np.isfinite(t.share)), key=lambda t: -t.share)
    if not trials:
        return None
    best = trials[0]
    near = (t.start for t in trials if t.model == best.model and t.share >= NEAR_BEST * best.share)
    starts = tuple(near)[:N_STARTS]
    return Screened(best.model, starts, best.share, tangent.known)


def _shapes(
    study: Study, tangent: Tangent, placed: PlacedEffect, own: Sequence[FreeParameter]
) -> list[Mapping[str, float]]:
    """Values to try of what a law is not linear in."""
    if placed.law.first_guess is FirstGuess.QUANTA:
        return [{own[0].name: step} for step in _steps(study, tangent, placed)]
    amplitudes = [p for p in own if _is_amplitude(placed, p.name)]
    shapes = [p for p in own if p not in amplitudes]
    rates = [p for p in amplitudes if placed.law.states and _unit(placed, p.name) == RATE]
    if placed.law.first_guess in (FirstGuess.PERIODS, FirstGuess.FREQUENCIES):
        lines = [{p.name: line} for p in shapes for line in _lines(study, tangent, placed)]
        if lines:
            return list(lines)
    return [
        {p.name: min(max(factor * p.start, p.low), p.high) for p in (*shapes, *rates)}
        for factor in _factors(placed, [*shapes, *rates])
    ]


def _factors(placed: PlacedEffect, shapes: Sequence[FreeParameter]) -> Sequence[float]:
    """Sizes to try of the shapes, over their scale."""
    if not shapes:
        return (1.0,)
    units = {_unit(placed, p.name) for p in shapes}
    if "Hz" in units:
        return FACTORS_OF_FREQUENCY
    return FACTORS_OF_TIME if units == {"s"} else FACTORS


def _steps(study: Study, tangent: Tangent, placed: PlacedEffect) -> list[float]:
    """Likely steps of a converter, where an output is the slot's value."""
    value = study.bench.compared_rows(study.signals[placed.place]["value"])[study.fit_rows]
    for i in range(study.measured.shape[1]):
        predicted = tangent.fit.predicted[study.fit_rows, i]
        if np.ptp(value) > 0.0 and np.corrcoef(predicted, value)[0, 1] > SAME:
            return likely_steps(predicted, study.measured[study.fit_rows, i] - predicted)
    return []


def _lines(study: Study, tangent: Tangent, placed: PlacedEffect) -> list[float]:
    """Likely periods or frequencies, where the part is linear around its replay."""
    injection = _injection(study, tangent, placed.place)
    if not injection.is_linear:
        return []

    def share(functions: Array) -> float:
        answers = bounded(injection.answer(functions)[study.fit_rows])
        return tangent.gain([answers[..., i].ravel() for i in range(2)], [-np.inf, -np.inf]).share

    position = study.signals[placed.place]["position"]
    if placed.law.first_guess is FirstGuess.PERIODS:
        return likely_periods(position, share, N_STARTS)
    return likely_frequencies(study.bench.times, position, share, N_STARTS)


def _injection(study: Study, tangent: Tangent, place: str) -> Injection:
    """Response of the outputs to what is added in a slot; the one that is known, if there is one."""
    if tangent.first_order is not None:
        return tangent.first_order.injection(place)
    return Injection(study, place, tangent.base_values)


def _trial(tangent: Tangent, model: ExtendedModel, shape: Mapping[str, float]) -> _Trial:
    """Share and amplitudes at one shape, probed with small amplitudes."""
    placed = model.effects[-1]
    amplitudes = [p for p in model.parameters if placed.owns(p.name) and _is_amplitude(placed, p.name)]
    if not amplitudes or placed.law.first_guess is FirstGuess.QUANTA:
        gain = tangent.gain([tangent.response(model, shape)], [0.0])
        return _Trial(gain.share, model, dict(shape))
    return _probed(tangent, model, amplitudes, shape, placed.law.probe)


def _probed(
    tangent: Tangent,
    model: ExtendedModel,
    amplitudes: Sequence[FreeParameter],
    shape: Mapping[str, float],
    probe: float,
) -> _Trial:
    """Amplitudes by regression: of a law with states all together, else each on its own."""
    is_joint = bool(model.effects[-1].law.states)
    absent = {p.name: 0.0 for p in amplitudes}
    typical = {p.name: min(max(probe * shape.get(p.name, p.start), p.low), p.high) for p in amplitudes}
    groups = [typical] if is_joint else [absent | {n: v} for n, v in typical.items()]
    responses = [tangent.response(model, {**shape, **group}) for group in groups]
    low = [0.0 if p.low >= 0.0 else -np.inf for p in amplitudes][: len(groups)]
    gain = tangent.gain(responses, low)
    factors = [gain.factors[0]] * len(typical) if is_joint else gain.factors
    sized = {}
    for p, factor in zip(amplitudes, factors, strict=True):
        least = LEAST_AMPLITUDE * p.start if p.low >= 0.0 else p.low
        sized[p.name] = float(min(max(factor * typical[p.name], least), p.high))
    return _Trial(gain.share, model, {**shape, **sized})


def _unit(placed: PlacedEffect, name: str) -> str:
    return next(v.unit for v in placed.law.parameters if v.name == placed.short_name(name))


def _is_amplitude(placed: PlacedEffect, name: str) -> bool:
    return placed.short_name(name) in placed.law.amplitudes

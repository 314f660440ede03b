"""
Which effects are worth a fit: one step of Gauss-Newton for each, at a few shapes.

The residual is regressed on the response of the outputs to the effect, beside the sensitivities of what is
fitted already. What a law is linear in are amplitudes, the regression gives their size: parameters in units
of the slot's value, and those that are zero without the effect. The others are shapes and are tried.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from fmu_sources.effects.framework.effect import FirstGuess
from master.diagnosis.numerics.arrays import Array
from master.diagnosis.numerics.least_squares import STEP, Fit, Parameter, bounded
from master.diagnosis.numerics.periods import likely_periods
from master.diagnosis.numerics.quanta import likely_steps
from master.diagnosis.replay.candidate_models import Added, fixed_values, parameters
from master.text.signal_name import SignalName

from .injection import Injection
from .study import Extended, Study

FACTORS = (0.1, 0.3, 1.0, 3.0)
FACTORS_OF_TIME = (0.1, 0.3, 0.6, 0.9, 1.2, 1.6, 2.2, 3.0)  # a delay of held values has several minima
FACTORS_OF_FREQUENCY = (0.1, 0.2, 0.4, 0.6, 1.0, 1.6, 2.5, 4.0)  # a resonance is seen from nearby only
RESPONSE_STEP = 1e-4
N_STARTS = 4
RATE = "{value}/{position}"
SAME = 0.999


@dataclass(frozen=True)
class Screened:
    """
    An effect with first guesses; `gain` is the share of the fitted residual power that it promises.

    `known` are the sensitivities to what is fitted already, before the effect, for the first steps of a fit.
    """

    extended: Extended
    starts: tuple[Mapping[str, float], ...]
    gain: float
    known: Mapping[str, Array]


class Tangent:
    """The fitted model so far, linearised: residual and sensitivities on the rows that are fitted on."""

    def __init__(self, study: Study, chosen: Extended, found: Fit) -> None:
        self.study, self.chosen, self.found = study, chosen, found
        self.rows = study.fit_rows
        self.fitted = (*study.base, *chosen.parameters)
        self.values = dict(chosen.fixed) | dict(found.values)
        self.base_values = {p.name: found.values[p.name] for p in study.base}
        self.alone: Array | None = None if chosen.added else found.predicted
        self.residual = self._scaled(study.measured - found.predicted)
        self.columns = [self._sensitivity(p) for p in self.fitted]
        prior = [
            p.scale * RESPONSE_STEP / (p.spread * RESPONSE_STEP) if p.spread else 0.0 for p in self.fitted
        ]
        self.prior = np.diag(prior)
        self.prior_left = np.array(
            [(p.start - found.values[p.name]) / p.spread if p.spread else 0.0 for p in self.fitted]
        )
        self.power = self._power([], [])[0]

    def response(self, extended: Extended, values: Mapping[str, float]) -> Array:
        """
        Scaled change of the outputs that an effect makes, on the rows that are fitted on.

        Beside effects in other slots it acts on the model without them: to first order the same, and built
        already. Behind effects in its own slot it sees what they give.
        """
        added = extended.added[-1]
        if any((a.fmu, a.slot) == (added.fmu, added.slot) for a in self.chosen.added):
            given = self.values | dict(extended.fixed) | dict(values)
            return self._scaled(self.study.simulate(extended.added, given) - self.found.predicted)
        if self.alone is None:
            self.alone = self.study.simulate((), self.base_values)
        given = self.base_values | {k: v for k, v in extended.fixed.items() if k not in self.chosen.fixed}
        return self._scaled(self.study.simulate((added,), given | dict(values)) - self.alone)

    def gain(self, responses: Sequence[Array], low: Sequence[float]) -> tuple[float, Array]:
        """Share of the power that responses take away, and their factors, none below its bound."""
        power, factors = self._power(responses, low)
        return 1.0 - power / self.power, factors

    def _power(self, responses: Sequence[Array], low: Sequence[float]) -> tuple[float, Array]:
        keep = list(range(len(responses)))
        factors = np.zeros(len(responses))
        while True:
            matrix = np.column_stack(
                [*self.columns, *(responses[i] for i in keep)] or [np.zeros_like(self.residual)]
            )
            n = len(self.columns)
            below = np.zeros((n, matrix.shape[1]))
            below[:, :n] = self.prior
            whole = np.vstack([matrix, below])
            target = np.concatenate([self.residual, self.prior_left])
            solution = np.linalg.lstsq(whole, target, rcond=1e-10)[0]
            found = solution[n : n + len(keep)]
            wrong = [i for i, f in zip(keep, found, strict=True) if f < low[i]]
            if not wrong:
                break
            keep = [i for i in keep if i not in wrong]
        for i, f in zip(keep, found, strict=True):
            factors[i] = f
        left = target - whole @ solution
        return float(left @ left), factors

    def _sensitivity(self, p: Parameter) -> Array:
        at = self.values[p.name]
        step = 10.0 * STEP * (1.0 if at + 10.0 * STEP * p.scale < p.high else -1.0)
        change = self.study.simulate(self.chosen.added, self.values | {p.name: at + step * p.scale})
        return self._scaled(change - self.found.predicted) / step

    def _scaled(self, values: Array) -> Array:
        return np.asarray(bounded(values / self.study.size)[self.rows].ravel())


def screened(study: Study, chosen: Extended, found: Fit, wanted: Sequence[Added]) -> list[Screened]:
    """Try all effects on the model so far, best first."""
    tangent = Tangent(study, chosen, found)
    tried = [_best(study, tangent, added) for added in wanted]
    return sorted((s for s in tried if s is not None), key=lambda s: -s.gain)


def _best(study: Study, tangent: Tangent, added: Added) -> Screened | None:
    """The best shape and side of one effect."""
    sizes = study.sizes(f"{added.fmu}.{added.slot}")
    found: list[tuple[float, Extended, dict[str, float]]] = []
    for variant in added.law.variants:
        own = parameters(added, sizes)
        extended = Extended(
            (*tangent.chosen.added, added),
            dict(tangent.chosen.fixed) | fixed_values(added, sizes, variant),
            (*tangent.chosen.started_at(tangent.found.values).parameters, *own),
        )
        amplitudes = [p for p in own if _is_amplitude(added, p.name)]
        shapes = [p for p in own if p not in amplitudes]
        rates = [p for p in amplitudes if added.law.states and _unit(added, p.name) == RATE]
        tried: Iterable[Mapping[str, float]] = (
            {p.name: min(max(factor * p.start, p.low), p.high) for p in (*shapes, *rates)}
            for factor in _factors(added, [*shapes, *rates])
        )
        if added.law.first_guess is FirstGuess.QUANTA:
            tried = [{own[0].name: step} for step in _steps(study, tangent, added)]
        if added.law.first_guess is FirstGuess.PERIODS:
            tried = [{p.name: period} for p in shapes for period in _periods(study, tangent, added)] or tried
        for at in tried:
            gain, sized = _sized(tangent, extended, added, at)
            found.append((gain, extended, {**at, **sized}))
    found = sorted((f for f in found if np.isfinite(f[0])), key=lambda f: -f[0])
    if not found:
        return None
    gain, extended, _ = found[0]
    starts = tuple(guess for _, e, guess in found if e == extended)[:N_STARTS]
    known = dict(zip([p.name for p in tangent.fitted], tangent.columns, strict=True))
    return Screened(extended, starts, gain, known)


def _factors(added: Added, shapes: Sequence[Parameter]) -> tuple[float, ...]:
    """Sizes to try of the shapes, over their scale."""
    if not shapes:
        return (1.0,)
    units = {_unit(added, p.name) for p in shapes}
    if "Hz" in units:
        return FACTORS_OF_FREQUENCY
    return FACTORS_OF_TIME if units == {"s"} else FACTORS


def _steps(study: Study, tangent: Tangent, added: Added) -> list[float]:
    """Likely steps of a converter, where an output is the slot's value."""
    value = study.bench.compared_rows(study.signals[f"{added.fmu}.{added.slot}"]["value"])[study.fit_rows]
    for i in range(study.measured.shape[1]):
        predicted = tangent.found.predicted[study.fit_rows, i]
        if np.ptp(value) > 0.0 and np.corrcoef(predicted, value)[0, 1] > SAME:
            return likely_steps(predicted, study.measured[study.fit_rows, i] - predicted)
    return []


def _periods(study: Study, tangent: Tangent, added: Added) -> list[float]:
    """Likely periods along the way, where the part is linear around its replay."""
    slot = f"{added.fmu}.{added.slot}"
    at = Injection(study, slot, tangent.base_values)
    if not at.is_linear:
        return []

    def gain(functions: Array) -> float:
        answers = bounded(at.answer(functions)[study.fit_rows])
        return tangent.gain([answers[..., i].ravel() for i in range(2)], [-np.inf, -np.inf])[0]

    return likely_periods(study.signals[slot]["position"], gain, N_STARTS)


def _sized(
    tangent: Tangent, extended: Extended, added: Added, at: Mapping[str, float]
) -> tuple[float, dict[str, float]]:
    """Gain and amplitudes at one shape, probed with small amplitudes."""
    own = [p for p in extended.parameters if p.name.startswith(f"{added.fmu}.{added.prefix}_")]
    amplitudes = [p for p in own if _is_amplitude(added, p.name)]
    if not amplitudes or added.law.first_guess is FirstGuess.QUANTA:
        return tangent.gain([tangent.response(extended, at)], [0.0])[0], {}
    return _probed(tangent, extended, amplitudes, at, added.law.probe)


def _probed(
    tangent: Tangent,
    extended: Extended,
    amplitudes: Sequence[Parameter],
    at: Mapping[str, float],
    probe: float,
) -> tuple[float, dict[str, float]]:
    is_joint = bool(extended.added[-1].law.states)
    absent = {p.name: 0.0 for p in amplitudes}
    typical = {p.name: min(max(probe * at.get(p.name, p.start), p.low), p.high) for p in amplitudes}
    groups = [typical] if is_joint else [absent | {n: v} for n, v in typical.items()]
    responses = [tangent.response(extended, {**at, **group}) for group in groups]
    low = [0.0 if p.low >= 0.0 else -np.inf for p in amplitudes][: len(groups)]
    gain, factors = tangent.gain(responses, low)
    each = [factors[0]] * len(typical) if is_joint else factors
    found = {}
    for p, factor in zip(amplitudes, each, strict=True):
        least = 1e-2 * p.start if p.low >= 0.0 else p.low
        found[p.name] = float(min(max(factor * typical[p.name], least), p.high))
    return gain, found


def _short(added: Added, name: str) -> str:
    return SignalName(name).variable.removeprefix(added.prefix + "_")


def _unit(added: Added, name: str) -> str:
    return next(v.unit for v in added.law.parameters if v.name == _short(added, name))


def _is_amplitude(added: Added, name: str) -> bool:
    return _short(added, name) in added.law.amplitudes

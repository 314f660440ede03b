"""One part under study: rows to fit on and to select by, the base, and models with effects as candidates."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from fmu_sources.effects.framework.effect import Rms
from master.diagnosis.case.case import Case
from master.diagnosis.case.cut import CutSystem, Values
from master.diagnosis.numerics.arrays import Array
from master.diagnosis.numerics.gains import Gain, over
from master.diagnosis.numerics.least_squares import Candidate, Fit, Parameter, fit
from master.diagnosis.replay.candidate_models import Added, Pool
from master.diagnosis.replay.replay import Bench
from master.diagnosis.replay.slot_signals import Signals, sizes, slot_signals
from master.errors import FmuError
from master.text.signal_name import SignalName

Progress = Callable[[str], None]
FEW_EVALUATIONS = 4
EXACT = 3e-5  # of what was measured: what rounding leaves


@dataclass(frozen=True)
class Extended:
    """The base with effects: what is fixed and what is fitted of each."""

    added: tuple[Added, ...] = ()
    fixed: Mapping[str, float] = field(default_factory=dict)
    parameters: tuple[Parameter, ...] = ()

    @property
    def name(self) -> str:
        """The last effect, as `fmu.slot: effect`."""
        return str(self.added[-1]) if self.added else "base"

    def started_at(self, values: Mapping[str, float]) -> Extended:
        """The same with other first guesses."""
        moved = tuple(replace(p, start=values.get(p.name, p.start)) for p in self.parameters)
        return replace(self, parameters=moved)


@dataclass
class Study:
    """What the search needs of a part."""

    system: CutSystem
    bench: Bench
    pool: Pool
    base: tuple[Parameter, ...]
    fit_rows: NDArray[np.bool_]
    held_out: list[slice]
    progress: Progress
    size: Array = field(default_factory=lambda: np.ones(1))
    signals: Signals = field(default_factory=dict)

    @property
    def measured(self) -> Array:
        """Measured outputs, shape (rows, outputs)."""
        return self.bench.measured

    def simulate(
        self, added: tuple[Added, ...], values: Mapping[str, float], *, everything: bool = False
    ) -> Array:
        """Replay with effects and values by `fmu.variable`; shape (rows, outputs), see `Bench.predict`."""
        player = self.pool.player(added)
        return self.bench.predict(player, merged(self.system.values, values), everything=everything)

    def candidate(
        self,
        extended: Extended,
        starts: Sequence[Mapping[str, float]] = ({},),
        known: Mapping[str, Array] | None = None,
    ) -> Candidate:
        """Base and effects as one model to fit; `known` sensitivities see `Candidate`."""
        parameters = (*self.base, *extended.parameters)
        names = [p.name for p in parameters]

        def simulate(theta: Array) -> Array:
            values = dict(extended.fixed) | dict(zip(names, theta.tolist(), strict=True))
            return self.simulate(extended.added, values)

        return Candidate(extended.name, parameters, simulate, tuple(starts), known or {})

    def fitted(
        self,
        extended: Extended,
        starts: Sequence[Mapping[str, float]] = ({},),
        evaluations: int = 25,
        tolerance: float = 1e-5,
        known: Mapping[str, Array] | None = None,
    ) -> Fit:
        """Fit base and effects together; of several first guesses the best after a few steps goes on."""
        extended, starts = self._with_start_values(extended, starts)
        if len(starts) > 1:
            begun = [
                self._fit(self.candidate(extended, [guess], known), FEW_EVALUATIONS, tolerance)
                for guess in starts
            ]
            starts = [min(begun, key=lambda f: f.cost).values]
        found = self._fit(self.candidate(extended, starts, known), evaluations, tolerance)
        values = dict(extended.fixed) | dict(found.values)
        return replace(found, predicted=self.simulate(extended.added, values, everything=True))

    def _fit(self, candidate: Candidate, evaluations: int, tolerance: float) -> Fit:
        return fit(
            candidate,
            self.measured,
            self.fit_rows,
            size=self.size,
            evaluations=evaluations,
            tolerance=tolerance,
        )

    def _with_start_values(
        self, extended: Extended, starts: Sequence[Mapping[str, float]]
    ) -> tuple[Extended, list[Mapping[str, float]]]:
        """Let the fit find start values of states too, from an estimate at each first guess."""
        player = self.pool.player(extended.added)
        bounds = {key: self.bench.starts[key] for key in self.bench.starts_of(player)}
        if not bounds:
            return extended, list(starts)
        known = {p.name: p.start for p in (*self.base, *extended.parameters)} | dict(extended.fixed)
        better: list[Mapping[str, float]] = []
        for guess in starts:
            here = {k: v for k, v in guess.items() if k in known}
            values = merged(self.system.values, known | here)
            for key in bounds:
                values[SignalName(key).instance].pop(SignalName(key).variable, None)
            better.append(dict(guess) | self.bench.estimated(player, values))
        taken = {p.name for p in extended.parameters}
        own = tuple(
            Parameter(key, 0.5 * (low + high), low, high, 0.25 * (high - low))
            for key, (low, high) in bounds.items()
            if key not in taken
        )
        return replace(extended, parameters=(*extended.parameters, *own)), better

    def is_exact(self, size: Array) -> bool:
        """Whether errors of such sizes, shape (outputs,), are those of rounding."""
        spread = self.measured[self.fit_rows].std(axis=0)
        return bool(np.all(size < EXACT * np.maximum(spread, 1e-300)))

    def nominal(self) -> Fit:
        """The base at the values of the system, as a fit."""
        values = {p.name: p.start for p in self.base}
        predicted = self.simulate((), values, everything=True)
        return Fit("system", values, dict.fromkeys(values, 0.0), predicted, np.inf, 0, ())

    def gain(self, before: Fit, after: Fit) -> Gain:
        """Gain of one fit over another on the held-out blocks."""
        return over(before, after, self.measured, self.held_out, self.size)

    def look_into_slots(self, base: Fit) -> None:
        """Note what stands in the slots along a replay of the base."""
        values = merged(self.system.values, base.values)
        self.signals = slot_signals(self.system, self.bench, self.pool.player(()), values)

    def sizes(self, slot: str) -> Rms:
        """Sizes of a slot's signals; a force that is zero is measured by the largest of its FMU."""
        found = sizes(self.signals[slot], len(self.measured) * self.bench.row_period)
        values = self.signals[slot]["value"]
        if np.any(values):
            return found
        fmu = SignalName(slot).instance + "."
        own = [s for k, s in self.signals.items() if k.startswith(fmu) and np.any(s["value"])]
        others = [sizes(s, 1.0).value for s in own]
        mechanical = [sizes(s, 1.0).value for s in own if "velocity" in s]
        return replace(found, value=max(mechanical or others or [1.0]))


def start(study: Study) -> Fit:
    """
    Fit the base, first scaled by what was measured, then by what that leaves.

    Raises:
        FmuError: If an FMU cannot be replayed on what was measured.
    """
    rows = study.fit_rows
    spread = study.measured[rows].std(axis=0)
    study.size = np.where(spread > 0.0, spread, 1.0)
    others = [{p.name: factor * p.start for p in study.base} for factor in (0.85, 1.2)] if study.base else []
    first = study.fitted(Extended(), [{}, *others], 30)
    if not np.isfinite(first.predicted[study.bench.in_use]).all():
        player = study.pool.player(())
        failure = study.bench.failure(player, merged(study.system.values, first.values))
        row = int(np.flatnonzero(~np.isfinite(first.predicted).all(axis=1))[0])
        if failure is None:
            raise FmuError(study.bench.part.fmus[0], f"the replay is not finite at row {row}")
        raise FmuError(failure.instance, f"the replay ends at row {row}: {failure}", status=failure.status)
    left = np.sqrt(np.nanmean((first.predicted - study.measured)[rows] ** 2, axis=0))
    study.size = np.maximum(left, 1e-9 * study.size)
    study.base = tuple(replace(p, scale=abs(first.values[p.name]) or p.scale) for p in study.base)
    return study.fitted(Extended(), [first.values], 30, 1e-9)


def base_parameters(case: Case, system: CutSystem, fmus: Sequence[str]) -> tuple[Parameter, ...]:
    """Parameters that the case allows to refit, from the values of the system."""
    found = []
    for key, entry in case.refit.items():
        fmu, variable = SignalName(key).parts
        if fmu in fmus:
            value = system.values[fmu].get(variable, system.descriptions[fmu].by_name[variable].start or 0.0)
            at = float(min(max(float(value), entry.low), entry.high))
            scale = abs(at) or 0.1 * (entry.high - entry.low)
            found.append(Parameter(key, at, entry.low, entry.high, scale, entry.spread))
    return tuple(found)


def merged(values: Values, given: Mapping[str, float]) -> Values:
    """Put values by `fmu.variable` over those of a system."""
    found = {name: dict(v) for name, v in values.items()}
    for key, value in given.items():
        fmu, variable = SignalName(key).parts
        found[fmu][variable] = value
    return found

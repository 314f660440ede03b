"""
What the outputs do under a law in a slot, to first order, without a model that holds it.

The law is evaluated on the slot's signals along a replay; what it adds there goes through the linear
response of the outputs (`injection.py`). Laws without states and linear ones with states can be evaluated so;
any other law with states has to be built and replayed.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from fmu_sources.effects.framework.effect import Effect
from fmu_sources.effects.framework.roles import Signals
from fmu_sources.framework.array_arithmetic import ARRAYS
from master.diagnosis.numerics.arrays import Array
from master.diagnosis.numerics.least_squares import Fit
from master.diagnosis.numerics.linear_memory import LinearMemory, Rates, linear_memory
from master.diagnosis.replay.placed_effect import PlacedEffect

from .extended_model import ExtendedModel
from .injection import Injection, applied_at_once, parameters
from .study import Study

ROLES = ("value", *Signals._fields)


@dataclass(frozen=True)
class FirstOrder:
    """Laws in the slots of a part, around a fitted model."""

    study: Study
    chosen: ExtendedModel
    fitted: Fit
    _injections: dict[str, Injection] = field(default_factory=dict)
    _signals_by_place: dict[str, Mapping[str, Array] | None] = field(default_factory=dict)

    @cached_property
    def base_values(self) -> dict[str, float]:
        """Values of the parameters that are refitted."""
        return {p.name: self.fitted.values[p.name] for p in self.study.base}

    def injection(self, place: str) -> Injection:
        """Response of the outputs to what is added in a slot `fmu.slot`."""
        if place not in self._injections:
            self._injections[place] = Injection(self.study, place, self.base_values)
        return self._injections[place]

    def covers(self, placed: PlacedEffect, values: Mapping[str, float]) -> bool:
        """Whether an effect with some values, by `fmu.variable`, needs no replay of its own."""
        if self.study.bench.is_windowed or self._signals(placed.place) is None:
            return False
        return self._is_evaluable(placed, values) and self.injection(placed.place).is_linear

    def change(self, placed: PlacedEffect, values: Mapping[str, float]) -> Array:
        """
        Scaled change of the outputs by an effect that is covered.

        Args:
            placed: The effect.
            values: Its parameters by `fmu.variable`; those that are missing have their start values.

        Returns:
            Shape (rows, outputs); infinite where the law is.
        """
        signals = self._signals(placed.place)
        assert signals is not None
        with np.errstate(all="ignore"):
            added = self._applied(placed, values, signals)["value"] - signals["value"]
        if not np.isfinite(added).all():
            return np.full(self.study.measured.shape, np.inf)
        return self.injection(placed.place).answer(added[:, None])[..., 0]

    def _signals(self, place: str) -> Mapping[str, Array] | None:
        """Signals of a slot with the effects so far; None if one of those there cannot be evaluated."""
        if place not in self._signals_by_place:
            self._signals_by_place[place] = self._signals_after(place)
        return self._signals_by_place[place]

    def _signals_after(self, place: str) -> Mapping[str, Array] | None:
        if not self.chosen.effects:
            return self.study.signals[place]
        values = dict(self.chosen.fixed) | dict(self.fitted.values)
        signals = self.study.slot_signals_with(self.chosen, values, place)
        for placed in self.chosen.effects:
            if placed.place == place:
                if not self._is_evaluable(placed, values):
                    return None
                signals = self._applied(placed, values, signals)
        return signals

    def _is_evaluable(self, placed: PlacedEffect, values: Mapping[str, float]) -> bool:
        law = placed.law
        if not law.states:
            return True
        model = self.study.system.model(placed.fmu)
        is_continuous = model is not None and model.sample_time is None
        return is_continuous and self._memory(placed, values) is not None

    def _applied(
        self, placed: PlacedEffect, values: Mapping[str, float], signals: Mapping[str, Array]
    ) -> Mapping[str, Array]:
        """Signals of the slot, shape (samples,) each, as they are after a law."""
        law = placed.law
        value = signals["value"]
        if law.states:
            memory = self._memory(placed, values)
            assert memory is not None
            return {**signals, "value": self._remembered(law, memory, signals)}
        applied = applied_at_once(placed, values, signals, self.study.bench.times)
        after = {"value": applied.value, **applied.signals}
        return {**signals, **{role: np.broadcast_to(v, value.shape) for role, v in after.items()}}

    def _remembered(self, law: Effect, memory: LinearMemory, signals: Mapping[str, Array]) -> Array:
        """Value after a linear law with states, which begins at rest in each recording."""
        bench = self.study.bench
        inputs = np.stack([signals[role] for role in ROLES if role in signals])
        answers = []
        for name, recording in bench.recordings.items():
            first = bench.first_sample(name)
            own = inputs[:, first : first + len(recording)]
            start = [own[0, 0] if v.name in law.follows else v.start for v in law.states]
            answers.append(memory.answer(np.array(start), own, bench.period))
        return np.concatenate(answers)

    def _memory(self, placed: PlacedEffect, values: Mapping[str, float]) -> LinearMemory | None:
        """Matrices of a law with states; None where it is not linear."""
        law = placed.law
        signals = self.study.signals[placed.place]
        sizes = {r: float(np.sqrt(np.mean(signals[r] ** 2))) or 1.0 for r in ROLES if r in signals}
        p = law.parameter_record.record(parameters(placed, values))

        def asked(states: Array, inputs: Array) -> Rates:
            own = dict(zip(sizes, inputs, strict=True))
            value = own.pop("value")
            applied = law.law(0.0, value, Signals(**own), law.state_record.record(list(states)), p, ARRAYS)
            rates = [np.broadcast_to(applied.changes[v.name], value.shape) for v in law.states]
            return Rates(np.broadcast_to(applied.value, value.shape), np.stack(rates))

        own_sizes = np.array([_scale(v.unit, sizes) for v in law.states])
        with np.errstate(all="ignore"):
            return linear_memory(asked, own_sizes, np.array([*sizes.values()]))


def _scale(unit: str, sizes: Mapping[str, float]) -> float:
    """Typical size of a state, from the signal that its unit names."""
    return next((size for role, size in sizes.items() if f"{{{role}}}" in unit), 1.0)

"""
Splines of a slot's signals, passed through the response from that slot to the outputs.

A law of the slot shows in an output only through the model between them. Which group of splines predicts a
residual says where a law is missing and what it is a law of.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.interpolate import BSpline

from fmu_sources.effects.framework.roles import roles
from master.diagnosis.numerics.arrays import Array
from master.diagnosis.search.injection import Injection
from master.diagnosis.search.study import Study
from master.text.signal_name import SignalName

N_KNOTS = 14
N_KNOTS_OF_SECOND = 6
DEGREE = 3
SIGNS = (0.01, 0.05)  # of the rms of a velocity, over which its sign is rounded
PAIRS = (
    *(("position", "velocity"), ("velocity", "position"), ("velocity", "time"), ("position", "time")),
    *(("value", "time"), ("value", "velocity"), ("velocity", "load"), ("velocity", "value")),
)
ROLES = ("position", "velocity", "value")


@dataclass(frozen=True)
class SlotLaw:
    """One group of splines: its slot `fmu.slot` and the roles of the signals that it is a law of."""

    place: str
    roles: tuple[str, ...]

    def __str__(self) -> str:
        return f"{' and '.join(self.roles)} in {self.place}"


@dataclass(frozen=True)
class SlotLaws:
    """Groups of splines of all slots of a part, around its base at some values by `fmu.variable`."""

    study: Study
    values: Mapping[str, float]

    @cached_property
    def columns(self) -> dict[SlotLaw, Array]:
        """Answers of the outputs to each group, shape (rows, outputs, splines), where the part is linear."""
        found: dict[SlotLaw, Array] = {}
        for place in self._places():
            injection = Injection(self.study, place, self.values)
            if injection.is_linear:
                found |= {law: injection.answer(functions) for law, functions in self._functions(place)}
        return found

    def _places(self) -> list[str]:
        """Slots of the equations, and outputs that are slots themselves."""
        return [place for place in self.study.signals if _slot_exists(self.study, place)]

    def _functions(self, place: str) -> Iterator[tuple[SlotLaw, Array]]:
        signals = dict(self.study.signals[place])
        signals["time"] = self.study.bench.times
        moving = {role: v for role, v in signals.items() if np.isfinite(v).all() and np.ptp(v) > 0.0}
        for role in ROLES:
            if role in moving:
                own = splines(moving[role], N_KNOTS)
                steps = _steps(moving[role]) if role == "velocity" else own[:, :0]
                yield SlotLaw(place, (role,)), np.hstack([own, steps])
        for first, second in PAIRS:
            if first in moving and second in moving:
                one = splines(moving[first], N_KNOTS)
                other = splines(moving[second], N_KNOTS_OF_SECOND)
                product = (one[:, :, None] * other[:, None, :]).reshape(len(one), -1)
                yield SlotLaw(place, (first, second)), product


def splines(values: Array, n: int) -> Array:
    """Cubic B-splines on quantiles of a signal (samples,), shape (samples, n); they sum to 1."""
    inner = np.quantile(values, np.linspace(0.0, 1.0, n - DEGREE + 1))
    inner = np.maximum.accumulate(inner + 1e-12 * np.ptp(values) * np.arange(len(inner)))
    knots = np.concatenate([np.repeat(inner[0], DEGREE), inner, np.repeat(inner[-1], DEGREE)])
    inside = np.clip(values, inner[0], np.nextafter(inner[-1], inner[0]))
    return np.asarray(BSpline.design_matrix(inside, knots, DEGREE).toarray())


def _steps(velocity: Array) -> Array:
    """Signs of a velocity, rounded over parts of its rms: friction that splines are too smooth for."""
    rms = float(np.sqrt(np.mean(velocity**2)))
    return np.column_stack([np.tanh(velocity / (share * rms)) for share in SIGNS])


def _slot_exists(study: Study, place: str) -> bool:
    fmu, slot = SignalName(place).parts
    return slot in study.system.slots(fmu) and roles(study.system.slots(fmu)[slot]) is not None

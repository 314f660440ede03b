"""
Nonparametric laws, laid out along a replay: which ones a slot can have, and their functions of time there.

A law is linear in its coefficients; the functions are what the coefficients are factors of.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from types import SimpleNamespace
from typing import NamedTuple

import numpy as np

from fmu_sources.effects.framework.effect import Place, Rms
from fmu_sources.effects.framework.roles import place, roles
from fmu_sources.effects.learned import MEMORY_TIME, N_PLAYS, WIDTHS, axes, coefficients, n_terms, terms
from fmu_sources.framework.array_arithmetic import ARRAYS
from master.diagnosis.numerics.arrays import Array
from master.diagnosis.numerics.memory import lagged, plays
from master.diagnosis.replay.placed_effect import PlacedEffect, fixed_values
from master.diagnosis.search.study import Study
from master.text.signal_name import SignalName

MECHANICAL = (
    *(("position", "velocity"), ("position", "sign"), ("velocity", "position")),
    *(("time", "position"), ("time", "sign"), ("plays", "position")),
)
SIGNAL = (("value", "memory"), ("time", "value"), ("time", "memory"), ("cycle", "memory"))
FREQUENCIES = np.arange(0.15, 3.0, 0.05)  # Hz


class _Stretch(NamedTuple):
    """One recording of a slot: time in its replay [s] and signals by role, shape (samples,) each."""

    t: Array
    signals: Mapping[str, Array]


@dataclass(frozen=True)
class Law:
    """One law in a slot: what is fixed of it and the names of its coefficients, as `fmu.variable`."""

    placed: PlacedEffect
    fixed: Mapping[str, float]
    names: tuple[str, ...]

    @property
    def smoothness(self) -> Array:
        """Second differences of neighbouring coefficients, or the coefficients of a law that is no spline."""
        first = axes(self.placed.effect)[0]
        n = len(self.names) // 2
        one = np.eye(n) if first in ("cycle", "plays") else np.diff(np.eye(n), n=2, axis=0)
        return np.asarray(np.kron(np.eye(2), one))

    def functions(self, study: Study, signals: Mapping[str, Array]) -> Array:
        """Functions of time, shape (samples, coefficients), from the signals of its slot."""
        fixed = {self.placed.short_name(k): v for k, v in self.fixed.items()}
        first, second = axes(self.placed.effect)
        columns = []
        for stretch in _by_recording(study, signals):
            x = SimpleNamespace(**_states(first, second, fixed, stretch.signals, study.bench.period))
            s = SimpleNamespace(**stretch.signals)
            p = SimpleNamespace(**fixed)
            columns.append(np.column_stack(terms(first, second, stretch.t, s, x, p, ARRAYS)))
        return np.concatenate(columns)


def laws(study: Study, places: Sequence[str]) -> list[list[Law]]:
    """Laws that fit the slots (`fmu.slot`); variants of one law that differ in a period form one list."""
    groups = []
    for key in places:
        fmu, name = SignalName(key).parts
        slot = study.system.slots(fmu)[name]
        pairs = MECHANICAL if place(slot) is Place.MECHANICAL else SIGNAL
        known = {*roles(slot), "value", "memory", "time", "cycle"}
        if "velocity" in known:
            known.add("sign")
        if "position" in known:
            known.add("plays")
        rms = study.signal_rms(key)
        groups += [
            _variants(PlacedEffect(fmu, name, f"learned_{a}_{b}"), rms) for a, b in pairs if {a, b} <= known
        ]
    return groups


def _variants(placed: PlacedEffect, rms: Rms) -> list[Law]:
    first = axes(placed.effect)[0]
    periods = [{"half_range_a": float(1.0 / f)} for f in FREQUENCIES] if first == "cycle" else [{}]
    names = tuple(placed.variable(n) for n in coefficients(first))
    assert len(names) == 2 * n_terms(first)
    return [Law(placed, fixed_values(placed, rms, period), names) for period in periods]


def _by_recording(study: Study, signals: Mapping[str, Array]) -> Iterator[_Stretch]:
    for name, recording in study.bench.recordings.items():
        first = study.bench.first_sample(name)
        rows = slice(first, first + len(recording))
        yield _Stretch(study.bench.times[rows], {role: v[rows] for role, v in signals.items()})


def _states(
    first: str, second: str, fixed: Mapping[str, float], signals: Mapping[str, Array], period: float
) -> dict[str, Array]:
    states = {}
    if second == "memory":
        states["lagged"] = lagged(signals["value"], period / MEMORY_TIME)
    if first == "plays":
        widths = np.array(WIDTHS) * fixed["half_range_a"]
        own = plays(signals["position"], widths)
        states |= {f"play_{i + 1}": own[:, i] for i in range(N_PLAYS)}
    return states

"""
Laws without a name, laid out along a replay: which ones a slot can have, and their functions of time there.

A law is linear in its coefficients; the functions are what the coefficients are factors of.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from types import SimpleNamespace

import numpy as np
from scipy.signal import lfilter, lfiltic

from fmu_sources.effects.framework.effect import Place, Rms
from fmu_sources.effects.framework.roles import place, roles
from fmu_sources.effects.learned import MEMORY_TIME, N_PLAYS, WIDTHS, axes, coefficients, n_terms, terms
from fmu_sources.framework.array_arithmetic import ARRAYS
from master.diagnosis.numerics.arrays import Array
from master.diagnosis.replay.candidate_models import Added, fixed_values
from master.diagnosis.search.study import Study
from master.text.signal_name import SignalName

MECHANICAL = (
    *(("position", "velocity"), ("position", "sign"), ("velocity", "position")),
    *(("time", "position"), ("time", "sign"), ("plays", "position")),
)
SIGNAL = (("value", "memory"), ("time", "value"), ("time", "memory"), ("cycle", "memory"))
FREQUENCIES = np.arange(0.15, 3.0, 0.05)  # Hz


@dataclass(frozen=True)
class Law:
    """One law in a slot: what is fixed of it and the names of its coefficients, as `fmu.variable`."""

    added: Added
    fixed: Mapping[str, float]
    names: tuple[str, ...]

    @property
    def smoothness(self) -> Array:
        """Second differences of neighbouring coefficients, or the coefficients of a law that is no spline."""
        first, n = axes(self.added.effect)[0], len(self.names) // 2
        one = np.eye(n) if first in ("cycle", "plays") else np.diff(np.eye(n), n=2, axis=0)
        return np.asarray(np.kron(np.eye(2), one))

    def functions(self, study: Study, signals: Mapping[str, Array]) -> Array:
        """Functions of time, shape (samples, coefficients), from the signals of its slot."""
        begin = f"{self.added.fmu}.{self.added.prefix}_"
        own = {k.removeprefix(begin): v for k, v in self.fixed.items()}
        first, second = axes(self.added.effect)
        found = []
        for t, part in _by_recording(study, signals):
            x = SimpleNamespace(**_states(first, second, own, part, study.bench.period))
            s = SimpleNamespace(**part)
            found.append(np.column_stack(terms(first, second, t, s, x, SimpleNamespace(**own), ARRAYS)))
        return np.concatenate(found)


def laws(study: Study, slots: Sequence[str]) -> list[list[Law]]:
    """Laws that fit the slots (`fmu.slot`); variants of one law that differ in a period stand together."""
    found = []
    for key in slots:
        fmu, name = SignalName(key).parts
        slot = study.system.slots(fmu)[name]
        pairs = MECHANICAL if place(slot) is Place.MECHANICAL else SIGNAL
        has = {*roles(slot), "value", "memory", "time", "cycle"}
        has |= {"sign"} & {"sign" for _ in has & {"velocity"}} | {"plays" for _ in has & {"position"}}
        sizes = study.sizes(key)
        found += [_variants(Added(fmu, name, f"learned_{a}_{b}"), sizes) for a, b in pairs if {a, b} <= has]
    return found


def _variants(added: Added, sizes: Rms) -> list[Law]:
    first = axes(added.effect)[0]
    periods = [{"half_range_a": float(1.0 / f)} for f in FREQUENCIES] if first == "cycle" else [{}]
    names = tuple(f"{added.fmu}.{added.prefix}_{n}" for n in coefficients(first))
    assert len(names) == 2 * n_terms(first)
    return [Law(added, fixed_values(added, sizes, period), names) for period in periods]


def _by_recording(study: Study, signals: Mapping[str, Array]) -> Iterator[tuple[Array, dict[str, Array]]]:
    at = 0
    for raw in study.bench.raw.values():
        rows = slice(at, at + len(raw))
        at += len(raw)
        yield np.asarray(np.arange(len(raw)) * study.bench.period), {k: v[rows] for k, v in signals.items()}


def _states(
    first: str, second: str, own: Mapping[str, float], signals: Mapping[str, Array], period: float
) -> dict[str, Array]:
    found = {}
    if second == "memory":
        found["lagged"] = _lagged(signals["value"], period / MEMORY_TIME)
    if first == "plays":
        widths = np.array(WIDTHS) * own["half_range_a"]
        plays = _plays(signals["position"], widths)
        found |= {f"play_{i + 1}": plays[:, i] for i in range(N_PLAYS)}
    return found


def _lagged(values: Array, share: float) -> Array:
    """First-order lag over `share` of its time constant a sample, at rest at the start."""
    q = float(np.exp(-share))
    b, a = [0.5 * (1.0 - q), 0.5 * (1.0 - q)], [1.0, -q]
    start = lfiltic(b, a, values[:1], values[:1])
    return np.asarray(lfilter(b, a, values, zi=start)[0])


def _plays(position: Array, widths: Array) -> Array:
    """Play operators of a position, shape (samples, widths), from zero."""
    found = np.zeros((len(position), len(widths)))
    steps = np.diff(position)
    for k, step in enumerate(steps):
        found[k + 1] = np.clip(found[k] + step, -widths, widths)
    return found

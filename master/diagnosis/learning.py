"""
A law without a name: splines over two signals of a slot, for what no listed effect explains.

Each coefficient is a small amplitude: the responses of the outputs to all of them give, by ridge regression
on the rows that are fitted on, what such a law would explain on the held-out blocks. The best pair of
signals is then fitted as a model of its own.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from fmu_sources.effects.effect import Place
from fmu_sources.effects.learned import COEFFICIENTS
from fmu_sources.effects.roles import place, roles

from .fitting import Fit, Parameter, bounded
from .ranking import Gain, gain, powers
from .study import Extended, Study
from .tables import Array
from .variants import Added, fixed_values, parameters

MECHANICAL = (("position", "velocity"), ("velocity", "memory"), ("position", "time"))
SIGNAL = (("value", "memory"), ("value", "time"))
SPREAD, RESPONSE = 0.3, 1e-3
EVALUATIONS = 4


@dataclass(frozen=True)
class Learned:
    """A learned law in a slot: the fit and its gain over the model without it."""

    extended: Extended
    gain: Gain
    shape: str

    @property
    def fit(self) -> Fit:
        """The fit of base and effects."""
        return self.gain.fit


def options(study: Study, slots: Sequence[str]) -> list[Added]:
    """Learned laws that fit slots (`fmu.slot`)."""
    found = []
    for key in slots:
        fmu, _, name = key.partition(".")
        slot = study.system.slots(fmu)[name]
        pairs = MECHANICAL if place(slot) is Place.MECHANICAL else SIGNAL
        has = {*roles(slot), "value", "memory", "time"}
        found += [Added(fmu, name, f"learned_{a}_{b}") for a, b in pairs if {a, b} <= has]
    return found


def learn(study: Study, chosen: Extended, found: Fit, slots: Sequence[str]) -> Learned | None:
    """Fit the learned law that explains most beside the effects chosen; None if there is no place for one."""
    tried = options(study, slots)
    if not tried:
        return None
    study.pool.build([(*chosen.added, a) for a in tried], study.progress)
    scored = []
    for added in tried:
        study.progress(f"{study.bench.part.name}: {added} learned")
        extended = _extended(study, chosen, found, added)
        score, guess = _linear(study, chosen, extended, found)
        scored.append((score, extended, guess))
    _, extended, guess = min(scored, key=lambda s: s[0])
    fitted = study.fitted(extended, [guess], EVALUATIONS)
    before, after = (
        powers(f.predicted - study.measured, study.held_out, study.size) for f in (found, fitted)
    )
    return Learned(extended, gain(fitted, before, after), describe(extended.added[-1], fitted))


def _extended(study: Study, chosen: Extended, found: Fit, added: Added) -> Extended:
    sizes = study.sizes(f"{added.fmu}.{added.slot}")
    own = tuple(
        replace(p, start=0.0, low=-np.inf, high=np.inf, spread=SPREAD * sizes.value)
        for p in parameters(added, sizes)
    )
    return Extended(
        (*chosen.added, added),
        dict(chosen.fixed) | fixed_values(added, sizes, {}),
        (*chosen.started_at(found.values).parameters, *own),
    )


def _linear(study: Study, chosen: Extended, extended: Extended, found: Fit) -> tuple[float, dict[str, float]]:
    """Held-out power with the best coefficients of one linear step, and these."""
    values = dict(extended.fixed) | dict(found.values)
    values |= {p.name: 0.0 for p in extended.parameters if p.name not in found.values}
    free: list[Parameter] = [*study.base, *extended.parameters]
    own = {p.name for p in extended.parameters[len(chosen.parameters) :]}
    columns, spreads = [], []
    for p in free:
        step = RESPONSE * p.spread if p.name in own and p.spread else 1e-4 * p.scale
        moved = study.simulate(extended.added, values | {p.name: values[p.name] + step}, everything=True)
        columns.append(bounded((moved - found.predicted) / study.size) / step)
        spreads.append(p.spread or np.inf)
    matrix, target = np.stack(columns, axis=-1), (study.measured - found.predicted) / study.size
    rows = study.fit_rows
    scale = np.maximum(np.sqrt(np.mean(matrix[rows] ** 2, axis=(0, 1))), 1e-30)
    a = (matrix[rows] / scale).reshape(-1, len(free))
    ridge = np.diag(1.0 / (np.array(spreads) * scale))
    b = np.concatenate([target[rows].ravel(), np.zeros(len(free))])
    solution = np.linalg.lstsq(np.vstack([a, ridge]), b, rcond=1e-10)[0] / scale
    left = bounded(target - matrix @ solution)
    score = float(np.mean([np.mean(left[block] ** 2) for block in study.held_out]))
    guess = {p.name: values[p.name] + s for p, s in zip(free, solution.tolist(), strict=True)}
    return score, guess


def describe(added: Added, found: Fit) -> str:
    """Say which signals, odd or even, memory or not."""
    first, second = added.effect.removeprefix("learned_").split("_")
    c = coefficients(added, found)
    odd = 0.5 * (c - c[::-1, ::-1])
    share = float(np.sum(odd**2) / max(np.sum(c**2), 1e-300))
    kind = "odd" if share > 0.8 else "even" if share < 0.2 else "neither odd nor even"
    spread = [float(np.sum((c - c.mean(axis=axis, keepdims=True)) ** 2)) for axis in (0, 1)]
    weak = first if spread[0] < 0.1 * spread[1] else second if spread[1] < 0.1 * spread[0] else None
    signals = f"{first} and {second}" if weak is None else (second if weak == first else first)
    memory = "with memory" if "memory" in signals else "without memory"
    changes = ", changing with time" if "time" in signals else ""
    return f"a smooth law of {signals} in {added.fmu}.{added.slot}, {kind}, {memory}{changes}"


def coefficients(added: Added, found: Fit) -> Array:
    """Coefficients of the splines, shape (7, 7)."""
    values = [found.values[f"{added.fmu}.{added.prefix}_{name}"] for name in COEFFICIENTS]
    n = round(np.sqrt(len(values)))
    return np.array(values).reshape(n, n)

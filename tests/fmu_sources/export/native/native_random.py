"""Random parameters and inputs within the rules of a model."""

from __future__ import annotations

import random

from fmu_sources.framework.model import Model
from fmu_sources.framework.variables import Role, Variable


def random_parameters(model: Model, rng: random.Random) -> dict[str, float]:
    """Draw every parameter near its start value, within its rule; the sampling period stays."""
    kept = {model.sample_time}
    chosen = [v for v in model.group(Role.PARAMETER) if v.name not in kept]
    return {v.name: _within(v, rng) for v in chosen}


def random_inputs(model: Model, rng: random.Random) -> list[float]:
    """Draw every input, small beside its unit so that the run stays finite."""
    return [v.start + 0.01 * rng.gauss(0.0, 1.0) for v in model.group(Role.INPUT)]


def _within(v: Variable, rng: random.Random) -> float:
    if v.boolean:
        return rng.random() < 0.5
    if v.items is not None:
        return int(rng.choice(list(v.items)))
    if v.integer:
        return rng.randint(int(v.minimum or 0), int(min(v.maximum or 10, (v.minimum or 0) + 50)))
    value = float(v.start) * rng.uniform(0.9, 1.1)
    return value if v.broken_rule(value) is None else float(v.start)

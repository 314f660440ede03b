"""A nonparametric law in words: which signals, odd or even, with memory or not."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from fmu_sources.effects.learned import axes
from master.diagnosis.numerics.arrays import TINY, Array
from master.diagnosis.replay.placed_effect import PlacedEffect

SMALL_SECOND = 0.01  # of the power of the first half: the law does not depend on its second signal
N_BINS = 24  # of the position
ONE_FUNCTION = 0.15  # share of the power of the squared speed that does not follow from the position
SYMMETRIC = 0.8  # share of the power that makes a law odd, or even


class Coefficients(NamedTuple):
    """Coefficients c_i and d_i of a law c(a) + d(a) b of two signals a and b."""

    c: Array
    d: Array


def coefficients(placed: PlacedEffect, values: Mapping[str, float]) -> Coefficients:
    """Pick the coefficients of a law from values by `fmu.variable`."""
    own = {placed.short_name(k): v for k, v in values.items() if placed.owns(k)}
    return Coefficients(
        c=np.array([v for k, v in own.items() if k.startswith("c_")]),
        d=np.array([v for k, v in own.items() if k.startswith("d_")]),
    )


def shows_memory(signals: Mapping[str, Array]) -> bool:
    """
    Whether a motion could show a memory: position and speed are not one function of each other.

    In a steady sine the speed follows from the position, and a law of both looks like any memory.
    """
    if not {"position", "velocity"} <= set(signals):
        return True
    position = signals["position"]
    power = signals["velocity"] ** 2
    if np.ptp(position) == 0.0 or np.ptp(power) == 0.0:
        return False
    edges = np.quantile(position, np.linspace(0.0, 1.0, N_BINS + 1))
    index = np.clip(np.searchsorted(edges, position, side="right") - 1, 0, N_BINS - 1)
    count = np.maximum(np.bincount(index, minlength=N_BINS), 1)
    mean = np.bincount(index, power, N_BINS) / count
    return bool(np.mean((power - mean[index]) ** 2) > ONE_FUNCTION * np.var(power))


def describe(placed: PlacedEffect, values: Mapping[str, float], *, memory_shown: bool = True) -> str:
    """
    Say what a law with these coefficients, by `fmu.variable`, depends on and how.

    `memory_shown`: see `shows_memory`.
    """
    first, second = axes(placed.effect)
    c, d = coefficients(placed, values)
    if first == "plays":
        return f"a law with memory of the position in {placed.place}"
    signals = first if np.sum(d**2) < SMALL_SECOND * np.sum(c**2) else f"{first} and {second}"
    signals = signals.replace("memory", "rate of the value").replace("sign", "direction of motion")
    if first == "cycle":
        return f"a law that oscillates with a period, of {signals}, in {placed.place}"
    if first == "time":
        return f"a law that changes with time, of {signals}, in {placed.place}"
    odd = 0.5 * (c - c[::-1])
    share = float(np.sum(odd**2) / max(np.sum(c**2), TINY))
    kind = "odd" if share > SYMMETRIC else "even" if share < 1.0 - SYMMETRIC else "neither odd nor even"
    memory = "without memory" if memory_shown else "with or without memory: the motion could not show one"
    return f"a smooth law of {signals} in {placed.place}, {kind}, {memory}"

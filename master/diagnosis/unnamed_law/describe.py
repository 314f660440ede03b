"""A nonparametric law in words: which signals, odd or even, with memory or not."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from fmu_sources.effects.learned import axes
from master.diagnosis.numerics.arrays import TINY, Array
from master.diagnosis.replay.placed_effect import PlacedEffect

SMALL_SECOND = 0.01  # of the power of the first half: the law does not depend on its second signal
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


def describe(placed: PlacedEffect, values: Mapping[str, float]) -> str:
    """Say what a law with these coefficients, by `fmu.variable`, depends on and how."""
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
    return f"a smooth law of {signals} in {placed.place}, {kind}, without memory"

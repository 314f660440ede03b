"""From a number between 0 and 1 to a value: the inverse of each distribution, truncated by bounds."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import special

from .campaign import LISTS, Vary

Floats = NDArray[np.float64]
Function = Callable[[Floats], Floats]


def points(vary: Vary) -> list[Any] | None:
    """List the values of one that has a list of them; None for a distribution."""
    if vary.values is not None:
        return list(vary.values)
    if vary.linspace is not None:
        return [float(v) for v in np.linspace(*vary.linspace)]
    if vary.logspace is not None:
        return [float(v) for v in np.geomspace(*vary.logspace)]
    return list(vary.choice) if vary.choice is not None else None


def places(vary: Vary, n: int, u: Floats) -> NDArray[np.int64]:
    """Choose of n listed values, by their weights; `u` has numbers from 0 to below 1."""
    if vary.weights is None:
        return np.minimum((u * n).astype(np.int64), n - 1)
    edges = np.cumsum(vary.weights) / math.fsum(vary.weights)
    return np.minimum(np.searchsorted(edges, u, side="right"), n - 1).astype(np.int64)


def drawn(vary: Vary, u: Floats) -> Floats:
    """Return the values of a distribution at its shares `u`, shape (n,), each from 0 to 1."""
    if vary.integers is not None:
        low, high = vary.integers
        return np.minimum(np.floor(low + u * (high - low + 1)), high)
    share, inverse = _pair(vary)
    if vary.bounds is None:
        return inverse(u)
    low, high = share(np.array(vary.bounds))
    return np.clip(inverse(low + u * (high - low)), *vary.bounds)


def has_room(vary: Vary) -> bool:
    """Whether bounds leave anything of a distribution."""
    if vary.bounds is None or vary.kind in LISTS:
        return True
    share, _ = _pair(vary)
    low, high = share(np.array(vary.bounds))
    return bool(high - low > 1e-12)


def _pair(vary: Vary) -> tuple[Function, Function]:
    """Return the distribution function and its inverse."""
    if vary.uniform is not None:
        low, high = vary.uniform
        return (
            lambda x: np.clip((x - low) / (high - low), 0.0, 1.0),
            lambda u: low + u * (high - low),
        )
    if vary.normal is not None:
        mean, deviation = vary.normal
        return (
            lambda x: special.ndtr((x - mean) / deviation),
            lambda u: mean + deviation * special.ndtri(_inside(u)),
        )
    if vary.lognormal is not None:
        median, deviation = vary.lognormal
        return (
            lambda x: special.ndtr(np.log(np.maximum(x, 1e-300) / median) / deviation),
            lambda u: median * np.exp(deviation * special.ndtri(_inside(u))),
        )
    assert vary.triangular is not None
    return _triangular(vary.triangular)


def _triangular(corners: Sequence[float]) -> tuple[Function, Function]:
    low, mode, high = corners
    rise = (mode - low) / (high - low)

    def share(x: Floats) -> Floats:
        x = np.clip(x, low, high)
        up = (x - low) ** 2 / ((high - low) * (mode - low)) if mode > low else np.zeros_like(x)
        down = 1.0 - (high - x) ** 2 / ((high - low) * (high - mode)) if high > mode else np.ones_like(x)
        return np.where(x < mode, up, down)

    def inverse(u: Floats) -> Floats:
        up = low + np.sqrt(u * (high - low) * (mode - low))
        down = high - np.sqrt((1.0 - u) * (high - low) * (high - mode))
        return np.where(u < rise, up, down)

    return share, inverse


def _inside(u: Floats) -> Floats:
    """Keep shares away from 0 and 1, where a normal distribution is infinite; a sequence may hold both."""
    return np.clip(u, 1e-16, 1.0 - 1e-16)

"""
How much more a connection bears before a pole leaves the unit circle: delay and gain.

A connection cut open has the loop transfer L(z) from what its target gets to what its source would send.
With a delay tau and a gain g more, poles are where 1 = g L(z) exp(-s tau), z = exp(s h). From a stable
system the first pole reaches the circle, as tau grows, at the least

    tau = (arg L(e^(j w h)) mod 2 pi)/w   over all w with |L(e^(j w h))| = 1,

and, as g goes up or down from 1, at the nearest g = 1/L(e^(j w h)) that is real and positive. Both are
found by root search over w; tau needs no whole steps (a value between two steps is one delayed exactly).
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq

from master.analysis.closed_loop.tick_matrix import LinearSystem, OpenedLoop
from master.system.graph import Wire

from .loop_transfer import LoopTransfer
from .poles import growth_rate

Floats = NDArray[np.float64]
Complexes = NDArray[np.complex128]

_N_GRID = 1500
_LARGEST_GAIN = 1e6
_LOWEST = 1e-5
_AROUND = np.concatenate([-np.geomspace(0.3, 1e-6, 12), np.geomspace(1e-6, 0.3, 12)])


@dataclass(frozen=True)
class Margin:
    """
    Margins of one connection of a stable system; None: nothing of this kind makes it unstable.

    `delay` [s] and the frequency [Hz] at which it starts to oscillate; gains as factors. `advance` [s]: by
    how much the connection may come earlier.
    """

    source: str
    target: str
    delay: float | None
    frequency: float | None
    gain_up: float | None
    gain_down: float | None
    advance: float | None = None


def margins(coupled: LinearSystem) -> list[Margin]:
    """Return the margins of all connections; none for an unstable system or FMUs of several rates."""
    if coupled.period != 1 or growth_rate(coupled) > 0.0:
        return []
    return [margin(coupled, wire) for wire in coupled.wires]


def margin(coupled: LinearSystem, wire: Wire) -> Margin:
    """Return the margins of one connection of a stable system in which every FMU steps each tick."""
    swept = _swept(coupled, wire)
    found = _delays(swept, coupled.step_size)
    gains = _gains(swept)
    return Margin(
        wire.source.name,
        wire.target.name,
        found.later,
        found.frequency,
        min((g for g in gains if g > 1.0), default=None),
        max((g for g in gains if 0.0 < g < 1.0), default=None),
        found.earlier,
    )


class DelayMargin(NamedTuple):
    """How much later, and how much earlier [s], a connection may come, and the frequency [Hz] if later."""

    later: float | None
    frequency: float | None
    earlier: float | None


def delay_margin(coupled: LinearSystem, wire: Wire) -> DelayMargin:
    """Return the delays alone, for a fraction of the time: a long delay line has many places of real gain."""
    return _delays(_swept(coupled, wire), coupled.step_size)


class _Swept(NamedTuple):
    """A loop, and its transfer on a grid of angles w h."""

    loop: LoopTransfer
    angles: Floats
    response: Complexes


def _swept(coupled: LinearSystem, wire: Wire) -> _Swept:
    opened = coupled.opened(wire, cut=True)
    loop = LoopTransfer(opened)
    angles = _angles(opened)
    return _Swept(loop, angles, loop.at(np.exp(1j * angles)))


def _delays(swept: _Swept, step: float) -> DelayMargin:
    crossings = _unit_gains(swept)
    first = min(crossings, key=lambda one: one.delay, default=None)
    return DelayMargin(
        None if first is None else first.delay * step,
        None if first is None else first.angle / (2.0 * math.pi * step),
        min((one.advance * step for one in crossings), default=None),
    )


def _angles(opened: OpenedLoop) -> Floats:
    """Grid of w h, fine near the poles of the open and the closed loop."""
    closed = opened.M + opened.N @ opened.P / (1.0 - opened.Q[0, 0])
    z = np.concatenate([np.linalg.eigvals(opened.M), np.linalg.eigvals(closed)])
    near = np.abs(np.angle(z[np.abs(z) > 0.5]))
    fine = near[:, None] * (1.0 + _AROUND)
    angles = np.concatenate([np.geomspace(_LOWEST, math.pi, _N_GRID), fine.ravel()])
    return np.unique(angles[(angles >= _LOWEST) & (angles <= math.pi)])


class _Crossing(NamedTuple):
    """Where |L| = 1: angle of a step, and how much later or earlier [steps] makes L = 1 there."""

    angle: float
    delay: float
    advance: float


def _unit_gains(swept: _Swept) -> list[_Crossing]:
    """Find all places where the loop has the gain 1."""

    def excess(angle: float) -> float:
        return math.log(max(abs(_at(swept.loop, angle)), 1e-300))

    found = []
    for angle in _roots(excess, swept.angles, np.abs(swept.response) - 1.0):
        phase = _phase(_at(swept.loop, angle))
        found.append(_Crossing(angle, phase / angle, (2.0 * math.pi - phase) / angle))
    return found


def _phase(value: complex) -> float:
    return math.atan2(value.imag, value.real) % (2.0 * math.pi)


def _gains(swept: _Swept) -> list[float]:
    loop, angles, response = swept
    crossings = _roots(lambda a: _at(loop, a).imag, angles, response.imag)
    values = [_at(loop, a) for a in crossings]
    values += [complex(v) for v in (response[-1],) if abs(v.imag) < 1e-9 * abs(v)]
    real = [v.real for v in values if v.real > 1.0 / _LARGEST_GAIN and abs(v.imag) < 1e-6 * v.real]
    return [1.0 / value for value in real]


def _at(loop: LoopTransfer, angle: float) -> complex:
    return complex(loop.at(np.exp(1j * np.array([angle])))[0])


def _roots(function: Callable[[float], float], angles: Floats, values: Floats) -> list[float]:
    places = np.flatnonzero(np.sign(values[:-1]) * np.sign(values[1:]) < 0)
    return [_root(function, float(angles[i]), float(angles[i + 1])) for i in places]


def _root(function: Callable[[float], float], low: float, high: float) -> float:
    """Where a function changes its sign; an end, where one is so near that another rounding takes it over."""
    at_low, at_high = function(low), function(high)
    if at_low * at_high >= 0.0:
        return low if abs(at_low) < abs(at_high) else high
    return float(brentq(function, low, high, xtol=1e-15, rtol=1e-12))

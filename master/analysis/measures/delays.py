"""
The fastest pole of a system in which a connection has more delay, whole steps or not.

A connection cut open has the loop transfer L(z). With d steps more, poles are where L(z) z^(-d) = 1. For
integers these are the eigenvalues of the system with d values under way. Between two integers each pole is
followed from both of them, in small steps of d by Newton's rule with

    dz/dd = ln z/(L'(z)/L(z) - d/z);

what L does not show, since no input reaches it, stays where it is.
"""

from __future__ import annotations

import cmath
import math

import numpy as np
from numpy.typing import NDArray

from master.analysis.closed_loop.tick_matrix import LinearSystem, OpenedLoop
from master.errors import ConfigError
from master.system.graph import Wire

from .poles import Fastest, Pole

Floats = NDArray[np.float64]

MOST_STEPS = 1000  # values under way: eigenvalues of a larger matrix take seconds each
_FOLLOWED = 8  # poles, those of largest modulus
_N_STEPS = 4
_N_NEWTON = 20
_CONVERGED = 1e-9
_SAME = 1e-7


def fastest_with_delay(coupled: LinearSystem, wire: Wire, delay: float) -> Fastest:
    """
    Find the pole that grows fastest.

    Args:
        coupled: The system; every FMU steps each tick.
        wire: The connection.
        delay: More than it has [s].

    Raises:
        ConfigError: If FMUs step at several rates, or the delay is below 0 or of too many steps.
    """
    if coupled.period != 1:
        raise ConfigError(["--sweep: no delay over FMUs of several rates, expected each to step every tick"])
    steps = delay / coupled.step_size
    if not 0.0 <= steps <= MOST_STEPS:
        longest = MOST_STEPS * coupled.step_size
        raise ConfigError(
            [f"--sweep: delay, got {delay:g} s, expected 0 to {longest:g} s, {MOST_STEPS} steps"]
        )
    loop = coupled.opened(wire, cut=True)
    found = _poles(loop, steps)
    place = max(found, key=abs, default=0j)
    growth = math.log(max(abs(place), 1e-300)) / coupled.step_size
    return Fastest(growth, Pole(place, coupled.step_size).zeta if place else 1.0)


def _poles(loop: OpenedLoop, steps: float) -> list[complex]:
    below = math.floor(steps)
    if math.isclose(steps, round(steps), abs_tol=1e-12):
        return _at_integer(loop, round(steps))
    ends = {n: _at_integer(loop, n) for n in (below, below + 1)}
    found = []
    for n, other in ((below, below + 1), (below + 1, below)):
        for pole in ends[n]:
            moved = _followed(loop, pole, float(n), steps)
            if moved is not None:
                found.append(moved)
            elif any(abs(pole - z) < _SAME for z in ends[other]):
                found.append(pole)
    return found


def _at_integer(loop: OpenedLoop, n: int) -> list[complex]:
    """Return the poles of largest modulus with n steps of delay."""
    M, N, P, Q = loop.M, loop.N[:, :1], loop.P[:1], float(loop.Q[0, 0])
    if n == 0:
        matrix = M + N @ P / (1.0 - Q)
    else:
        size = len(M)
        matrix = np.zeros((size + n, size + n))
        matrix[:size, :size] = M
        matrix[:size, -1] = N[:, 0]
        matrix[size, :size] = P[0]
        matrix[size, -1] += Q
        matrix[size + 1 :, size:-1] = np.eye(n - 1)
    z = np.linalg.eigvals(matrix)
    return [complex(v) for v in z[np.argsort(-np.abs(z))[:_FOLLOWED]]]


def _followed(loop: OpenedLoop, pole: complex, begin: float, end: float) -> complex | None:
    """Follow a pole from one delay to another; None if L does not show it, or it leaves |arg z| <= pi."""
    z = pole
    for d in np.linspace(begin, end, _N_STEPS + 1)[1:].tolist():
        found = _newton(loop, z, d)
        if found is None:
            return None
        z = found
    return z


def _newton(loop: OpenedLoop, z: complex, d: float) -> complex | None:
    """Solve ln L(z) - d ln z = 2 pi i k by Newton's rule from near its root."""
    for _ in range(_N_NEWTON):
        value, slope = _transfer(loop, z)
        if not (cmath.isfinite(value) and cmath.isfinite(slope)) or value == 0.0 or z == 0.0:
            return None
        wrapped = value * cmath.exp(-d * cmath.log(z))
        if not cmath.isfinite(wrapped) or wrapped == 0.0:
            return None
        excess = cmath.log(wrapped)
        gradient = slope / value - d / z
        if gradient == 0.0:
            return None
        change = excess / gradient
        if abs(change) > 0.5 * abs(z):
            return None
        z -= change
        if abs(change) <= _CONVERGED * abs(z):
            return z
    return None


def _transfer(loop: OpenedLoop, z: complex) -> tuple[complex, complex]:
    """Return L(z) and its derivative; infinite at a pole of the open loop."""
    matrix = z * np.eye(len(loop.M)) - loop.M
    try:
        states = np.linalg.solve(matrix, loop.N[:, :1].astype(complex))
        slopes = np.linalg.solve(matrix, states)
    except np.linalg.LinAlgError:
        return complex(math.inf), complex(math.inf)
    value = complex((loop.P[:1] @ states)[0, 0] + loop.Q[0, 0])
    return value, complex(-(loop.P[:1] @ slopes)[0, 0])

"""
The fastest pole of a system in which connections have more delay, whole steps or not.

Connections cut open have the loop transfer L(z), a row and a column for each. With d_i steps more, poles are
where g(z) = 1 - det(I - L(z) diag(z^(-d_i))) = 1; of one connection g = L(z) z^(-d). For integers these are
the eigenvalues of the system with d_i values under way. Between integers each pole is followed from the
corners of the cell of integers around d, in small steps by Newton's rule for ln g(z) = 0; what L does not
show, since no input reaches it, stays where it is.
"""

from __future__ import annotations

import cmath
import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from master.analysis.closed_loop.tick_matrix import LinearSystem, OpenedLoop
from master.errors import ConfigError
from master.system.graph import Wire

from .poles import Fastest, Pole

Floats = NDArray[np.float64]
Complexes = NDArray[np.complex128]

MOST_STEPS = 1000  # values under way: eigenvalues of a larger matrix take seconds each
_FOLLOWED = 8  # poles, those of largest modulus
_N_STEPS = 4
_N_NEWTON = 20
_CONVERGED = 1e-9
_SAME = 1e-7


@dataclass(frozen=True)
class ExtraDelay:
    """What a connection has in addition to its own delay [s]."""

    wire: Wire
    delay: float


def fastest_with_delays(coupled: LinearSystem, delays: Sequence[ExtraDelay]) -> Fastest:
    """
    Find the pole that grows fastest.

    Args:
        coupled: The system; every FMU steps each tick.
        delays: Connections, each once, and what they have more.

    Raises:
        ConfigError: If FMUs step at several rates, or a delay is below 0 or of too many steps.
    """
    if coupled.period != 1:
        raise ConfigError(["--sweep: no delay over FMUs of several rates, expected each to step every tick"])
    steps = [extra.delay / coupled.step_size for extra in delays]
    for extra, own in zip(delays, steps, strict=True):
        if not 0.0 <= own <= MOST_STEPS:
            longest = MOST_STEPS * coupled.step_size
            raise ConfigError(
                [f"--sweep: delay, got {extra.delay:g} s, expected 0 to {longest:g} s, {MOST_STEPS} steps"]
            )
    loop = coupled.opened(*(extra.wire for extra in delays), cut=True)
    found = _poles(loop, np.array(steps))
    place = max(found, key=abs, default=0j)
    growth = math.log(max(abs(place), 1e-300)) / coupled.step_size
    return Fastest(growth, Pole(place, coupled.step_size).zeta if place else 1.0)


def _poles(loop: OpenedLoop, steps: Floats) -> list[complex]:
    corners = [_integers_around(own) for own in steps.tolist()]
    ends = {corner: _at_integers(loop, corner) for corner in itertools.product(*corners)}
    if len(ends) == 1:
        [poles] = ends.values()
        return poles
    found = []
    for corner, poles in ends.items():
        others = [ends[other] for other in ends if other != corner]
        for pole in poles:
            moved = _followed(loop, pole, np.array(corner, dtype=float), steps)
            if moved is not None:
                found.append(moved)
            elif all(any(abs(pole - z) < _SAME for z in other) for other in others):
                found.append(pole)
    return found


def _integers_around(steps: float) -> tuple[int, ...]:
    """Return the two integers around a number; one if it is an integer itself."""
    if math.isclose(steps, round(steps), abs_tol=1e-12):
        return (round(steps),)
    return (math.floor(steps), math.floor(steps) + 1)


def _at_integers(loop: OpenedLoop, steps: Sequence[int]) -> list[complex]:
    """Return the poles of largest modulus with integer steps of delay: values on their way are states."""
    size = len(loop.M)
    total = size + sum(steps)
    last = size - 1 + np.cumsum(steps)
    delayed = [i for i, n in enumerate(steps) if n]
    direct = [i for i, n in enumerate(steps) if not n]
    sent = np.zeros((len(steps), total))
    sent[:, :size] = loop.P
    arriving = np.zeros_like(sent)
    arriving[delayed, last[delayed]] = 1.0
    inner = np.eye(len(direct)) - loop.Q[np.ix_(direct, direct)]
    arriving[direct] = np.linalg.solve(inner, sent[direct] + loop.Q[direct] @ arriving)
    sent += loop.Q @ arriving
    matrix = np.zeros((total, total))
    matrix[:size, :size] = loop.M
    matrix[:size] += loop.N @ arriving
    for i in delayed:
        first = last[i] - steps[i] + 1
        matrix[first] = sent[i]
        matrix[first + 1 : last[i] + 1, first : last[i]] = np.eye(steps[i] - 1)
    z = np.linalg.eigvals(matrix)
    return [complex(v) for v in z[np.argsort(-np.abs(z))[:_FOLLOWED]]]


def _followed(loop: OpenedLoop, pole: complex, begin: Floats, end: Floats) -> complex | None:
    """Follow a pole from delays to others; None if L does not show it, or it leaves |arg z| <= pi."""
    z = pole
    for d in np.linspace(begin, end, _N_STEPS + 1)[1:]:
        found = _newton(loop, z, d)
        if found is None:
            return None
        z = found
    return z


def _newton(loop: OpenedLoop, z: complex, d: Floats) -> complex | None:
    """Solve ln g(z) = 0 by Newton's rule from near its root."""
    for _ in range(_N_NEWTON):
        if z == 0.0:
            return None
        value, slope = _loop_gain(loop, z, d)
        if not (cmath.isfinite(value) and cmath.isfinite(slope)) or value == 0.0 or slope == 0.0:
            return None
        change = cmath.log(value) * value / slope
        if not cmath.isfinite(change) or abs(change) > 0.5 * abs(z):
            return None
        z -= change
        if abs(change) <= _CONVERGED * abs(z):
            return z
    return None


def _loop_gain(loop: OpenedLoop, z: complex, d: Floats) -> tuple[complex, complex]:
    """Return g(z) and its derivative, which is that of a determinant: tr(adj(I - W) W')."""
    transfer, slopes = _transfer(loop, z)
    late = np.exp(-d * cmath.log(z))
    W = transfer * late
    dW = (slopes - transfer * d / z) * late
    if len(d) == 1:
        return complex(W[0, 0]), complex(dW[0, 0])
    A = np.eye(len(d)) - W
    if not np.isfinite(A).all():
        return complex(math.inf), complex(math.inf)
    return complex(1.0 - np.linalg.det(A)), complex(np.trace(_adjugate(A) @ dW))


def _adjugate(A: Complexes) -> Complexes:
    """Return the transposed cofactors of a small matrix, which may be singular: at a pole it is."""
    n = len(A)
    cofactors = np.empty_like(A)
    for i, j in itertools.product(range(n), repeat=2):
        rest = np.delete(np.delete(A, i, axis=0), j, axis=1)
        cofactors[i, j] = (-1.0) ** (i + j) * np.linalg.det(rest)
    return cofactors.T


def _transfer(loop: OpenedLoop, z: complex) -> tuple[Complexes, Complexes]:
    """Return L(z) and its derivative; infinite at a pole of the open loop."""
    matrix = z * np.eye(len(loop.M)) - loop.M
    try:
        states = np.linalg.solve(matrix, loop.N.astype(complex))
        slopes = np.linalg.solve(matrix, states)
    except np.linalg.LinAlgError:
        nowhere = np.full(loop.Q.shape, complex(math.inf))
        return nowhere, nowhere
    values: Complexes = np.asarray(loop.P @ states + loop.Q, dtype=complex)
    return values, np.asarray(-(loop.P @ slopes), dtype=complex)

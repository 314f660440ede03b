"""
A law with states that is linear, found out by asking it, and answered at once for a whole signal.

    x' = A x + B u,   y = C x + D u,   u linear between samples

With x(k+1) = F x(k) + G_1 u(k) + G_2 (u(k+1) - u(k)) and xi = x - G_2 u the samples follow

    xi(k+1) = F xi(k) + (F G_2 + G_1 - G_2) u(k),   y(k) = C xi(k) + (C G_2 + D) u(k)

Source: Franklin, Powell, Workman, Digital Control of Dynamic Systems (1998), Sec. 6.3 (triangle hold).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from scipy.linalg import expm
from scipy.signal import lfilter, ss2tf

from .arrays import Array

N_CHECKS = 24  # points at which a law has to be what its values at unit points make of it
REACH = 4.0  # of the scales: how far out they are
LINEAR = 1e-8  # relative departure
SEED = 1


class Rates(NamedTuple):
    """What a law gives at points: its value, shape (points,), rates of its states, shape (states, points)."""

    value: Array
    rates: Array


Law = Callable[[Array, Array], Rates]
"""From states (states, points) and inputs (inputs, points)."""


@dataclass(frozen=True)
class LinearMemory:
    """Matrices of a linear law, A (n, n), B (n, m), C (n,) and D (m,)."""

    a: Array
    b: Array
    c: Array
    d: Array

    def answer(self, start: Array, inputs: Array, period: float) -> Array:
        """
        Answer to sampled inputs.

        Args:
            start: States at the first sample, shape (n,).
            inputs: Shape (m, samples).
            period: Time between samples.

        Returns:
            Shape (samples,).
        """
        n, m = self.b.shape
        whole = np.zeros((n + 2 * m, n + 2 * m))
        whole[:n, :n] = period * self.a
        whole[:n, n : n + m] = period * self.b
        whole[n : n + m, n + m :] = np.eye(m)
        grown = expm(whole)
        f = grown[:n, :n]
        held = grown[:n, n : n + m]
        ramp = grown[:n, n + m :]
        into = f @ ramp + held - ramp
        through = self.c @ ramp + self.d
        first = start - ramp @ inputs[:, 0]
        impulse = np.zeros(inputs.shape[1])
        impulse[0] = 1.0
        answer = _filtered(f, f @ first, self.c, float(self.c @ first), impulse)
        for i in range(m):
            if np.any(inputs[i]):
                answer += _filtered(f, into[:, i], self.c, float(through[i]), inputs[i])
        return answer


def linear_memory(law: Law, scales_of_states: Array, scales_of_inputs: Array) -> LinearMemory | None:
    """
    Find the matrices of a law; None if it is not linear within a few of the scales, or not about zero.

    Args:
        law: The law.
        scales_of_states: Typical sizes, shape (n,).
        scales_of_inputs: Shape (m,).
    """
    scales = np.concatenate([scales_of_states, scales_of_inputs])
    n = len(scales_of_states)
    units = np.diag(scales)
    checks = np.random.default_rng(SEED).uniform(-REACH, REACH, (len(scales), N_CHECKS)) * scales[:, None]
    points = np.hstack([np.zeros((len(scales), 1)), units, checks])
    found = law(points[:n], points[n:])
    values = np.vstack([found.rates, found.value])
    if not np.isfinite(values).all():
        return None
    matrix = values[:, 1 : 1 + len(scales)] / scales
    largest = np.abs(matrix) @ scales + np.abs(values[:, 0])
    if np.any(np.abs(matrix @ points - values) > LINEAR * REACH * largest[:, None]):
        return None
    return LinearMemory(matrix[:n, :n], matrix[:n, n:], matrix[n, :n], matrix[n, n:])


def _filtered(f: Array, into: Array, out: Array, through: float, values: Array) -> Array:
    numerator, denominator = ss2tf(f, into[:, None], out[None, :], np.array([[through]]))
    return np.asarray(lfilter(numerator[0], denominator, values))

"""Zeros of the closed loop from a push on a connection to a signal."""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy.linalg import eig

from master.analysis.closed_loop.tick_matrix import LinearSystem
from master.system.graph import Wire

from .poles import SMALLEST_MODULUS, Pole

_LARGEST_MODULUS = 1e3


def zeros(coupled: LinearSystem, wire: Wire, signal: str) -> list[Pole]:
    """Return the finite z at which a push on top of the wire's value does not reach the signal."""
    opened = coupled.opened(wire, cut=False)
    n = len(opened.M)
    pencil = np.block([[opened.M, opened.N], [coupled.row(signal), 0.0]])
    unit = np.zeros((n + 1, n + 1))
    unit[:n, :n] = np.eye(n)
    found: Any = eig(pencil, unit, right=False)
    finite = found[np.isfinite(found)]
    shown = [z for z in finite if SMALLEST_MODULUS < abs(z) < _LARGEST_MODULUS and z.imag >= 0.0]
    return [Pole(complex(z), coupled.step_size) for z in sorted(shown, key=lambda z: -abs(z))]

"""Frequency responses of linear systems, as rows of a run show them: y(k) over u(k)."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from master.analysis.closed_loop.tick_matrix import LinearSystem
from master.analysis.state_space import StateSpace
from master.system.graph import Wire

Floats = NDArray[np.float64]
Complexes = NDArray[np.complex128]


def response(system: StateSpace, step_size: float, frequencies: Floats) -> Complexes:
    """
    Response of the first output to the first input of one FMU.

    Args:
        system: The FMU.
        step_size: [s].
        frequencies: [Hz], shape (n,).

    Returns:
        z^-1 (C (z - A)^-1 B + D): the output of a row over the input that was set for the step before it.
    """
    z = _circle(frequencies, step_size)
    states = _solved(system.A, system.B[:, 0], z)
    return np.asarray((states @ system.C[0] + system.D[0, 0]) / z)


def response_from(coupled: LinearSystem, wire: Wire, signal: str, frequencies: Floats) -> Complexes:
    """Response of a signal, row by row, over the source of a connection that is cut there."""
    opened = coupled.opened(wire, cut=True)
    z = _circle(frequencies, coupled.step_size)
    states = _solved(opened.M, opened.N[:, 0], z)
    group = coupled.schedule.group_of
    age = 0 if group(wire.source.instance) < group(wire.target.instance) else 1
    return np.asarray(states @ coupled.row(signal) * z ** (1 - age))


def _circle(frequencies: Floats, step_size: float) -> Complexes:
    return np.asarray(np.exp(2j * np.pi * frequencies * step_size))


def _solved(A: Floats, b: Floats, z: Complexes) -> Complexes:
    """Solve (z - A) x = b for each z; shape (len(z), len(b))."""
    sides = np.broadcast_to(b[:, None], (len(z), len(b), 1))
    return np.asarray(np.linalg.solve(z[:, None, None] * np.eye(len(A)) - A, sides)[:, :, 0])

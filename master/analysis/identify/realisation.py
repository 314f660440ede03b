"""
The smallest linear system that answers as an FMU did.

    x(k+1) = A x(k) + B u(k)
    y(k+1) = C x(k) + D u(k)          y(k+1): outputs after the step, u(k): inputs set before it

    H0[i, j] = C A^(i+j) [B X0],   H1[i, j] = C A^(i+j+1) [B X0],   H0 = U S V'
    A = S^-1/2 U' H1 V S^-1/2,   C = first rows of U S^1/2,   [B X0] = first columns of S^1/2 V'

X0 holds the states from which changed start values begin, so that modes that no input reaches appear too.
The rows i and columns j are dense at first (a dead time fills them) and sparse later (slow modes). The
order is the least one that repeats all measured rows to GOAL, or not much worse than any order does.
Source   Ho, Kalman (1966); Juang, Pappa, An eigensystem realization algorithm, J. Guidance 8 (1985) 620-627.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from master.analysis.state_space import StateSpace

from .responses import Responses

Floats = NDArray[np.float64]

GOAL = 1e-9
_WORSE_THAN_BEST = 20.0
_DENSE = (16, 136)
_SPARSE = 12
_TOLERANCES = tuple(10.0 ** (-0.5 * n) for n in range(6, 29))


def realise(responses: Responses) -> StateSpace:
    """Find the smallest system; with dense rows enough for a long dead time only where it needs them."""
    markov = np.concatenate([responses.pulses[1:], responses.free[:-1]], axis=2)
    outputs = np.max(np.abs(markov), axis=(0, 2), initial=0.0)
    outputs[outputs == 0.0] = 1.0
    scaled = markov / outputs[:, None]
    columns = np.max(np.abs(scaled), axis=(0, 1), initial=0.0)
    columns[columns == 0.0] = 1.0
    scaled = scaled / columns
    found = _realise(scaled, _DENSE[0])
    if found.misfit > GOAL:
        found = min(found, _realise(scaled, _DENSE[1]), key=lambda one: one.misfit)
    B = found.B * columns
    n = responses.pulses.shape[2]
    return StateSpace(
        A=found.A,
        B=B[:, :n],
        C=outputs[:, None] * found.C,
        D=responses.pulses[0],
        X0=B[:, n:],
        misfit=found.misfit,
        curvature=responses.curvature,
    )


class _Realisation(NamedTuple):
    """Matrices of scaled rows, and the largest relative error of what they repeat."""

    A: Floats
    B: Floats
    C: Floats
    misfit: float


def _realise(markov: Floats, dense: int) -> _Realisation:
    n, n_outputs, n_columns = markov.shape
    half = (n - 1) // 2
    places = np.unique(np.concatenate([np.arange(dense), np.arange(dense, half, _SPARSE)]))
    H0, H1 = (_hankel(markov, places, shift) for shift in (0, 1))
    U, S, Vt = np.linalg.svd(H0, full_matrices=False)
    nothing = _Realisation(
        np.zeros((0, 0)), np.zeros((0, n_columns)), np.zeros((n_outputs, 0)), _largest(markov)
    )
    found = [nothing]
    for r in _orders(S):
        if found[-1].misfit < GOAL:
            break
        root = np.sqrt(S[:r])
        A = (U[:, :r].T / root[:, None]) @ H1 @ (Vt[:r].T / root)
        B = root[:, None] * Vt[:r, :n_columns]
        C = U[:n_outputs, :r] * root
        found.append(_Realisation(A, B, C, _misfit(markov, A, B, C)))
    enough = max(GOAL, _WORSE_THAN_BEST * min(one.misfit for one in found))
    return next(one for one in found if one.misfit <= enough)


def _orders(S: Floats) -> list[int]:
    """Orders to try, smallest first: up to each tolerance of the singular values."""
    return sorted({int(np.sum(tolerance * np.max(S, initial=0.0) < S)) for tolerance in _TOLERANCES} - {0})


def _hankel(markov: Floats, places: NDArray[np.int64], shift: int) -> Floats:
    blocks = markov[places[:, None] + places[None, :] + shift]
    i, j, p, q = blocks.shape
    hankel: Floats = blocks.transpose(0, 2, 1, 3).reshape(i * p, j * q)
    return hankel


def _misfit(markov: Floats, A: Floats, B: Floats, C: Floats) -> float:
    """Largest error over all rows, relative to each column's largest value; infinite if it runs away."""
    x = B
    worst = 0.0
    for row in markov:
        worst = max(worst, _largest(C @ x - row))
        if not worst < 1e3:
            return float("inf")
        x = A @ x
    return worst


def _largest(values: Floats) -> float:
    return float(np.max(np.abs(values), initial=0.0))

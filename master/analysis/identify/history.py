"""
A linear FMU that varies with time, in coordinates that do not: its last outputs and inputs.

    y(k) = sum_l A_l(k) y(k-l) + sum_l B_l(k) u(k-l)    y(k): outputs after step k, u(k): inputs before it

The answers g(k, q) after step k to a pulse of age q (in step k - q) give the coefficients: where q > n no
input is left in the equation, and A(k) follows by least squares; then
B_l(k) = g(k, l) - sum_i A_i(k) g(k-i, l-i).
The order n is the least one that repeats all answers.
Source   Majji, Juang, Junkins, Time-varying eigensystem realization algorithm, J. Guidance 33 (2010) 13-28,
         with the last outputs as the observable coordinates.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from master.analysis.state_space import StateSpace

Floats = NDArray[np.float64]

AGES = 24
_LARGEST_ORDER = 6
_GOAL = 1e-9
_SMALLEST = 1e-11


def systems(answers: Floats, earlier: Floats) -> list[StateSpace]:
    """
    Find the linear system of each tick.

    Args:
        answers: g(k, q), shape (ticks, ages, outputs, inputs).
        earlier: g(k - l, q - l) at [l - 1, k, q], shape (orders, ticks, ages, outputs, inputs), 0 where there
            was no pulse.
    """
    outputs = np.max(np.abs(answers), axis=(0, 1, 3), initial=0.0)
    inputs = np.max(np.abs(answers / _positive(outputs)[:, None]), axis=(0, 1, 2), initial=0.0)
    outputs = _positive(outputs)
    inputs = _positive(inputs)
    scale = outputs[:, None] * inputs
    best: list[StateSpace] = []
    enough = np.inf
    for n in range(1, len(earlier) + 1):
        found = _coefficients(answers / scale, earlier[:n] / scale)
        A = (found.A * outputs[:, None] / outputs).transpose(1, 0, 2, 3)
        B = (found.B * scale).transpose(1, 0, 2, 3)
        if not best or found.misfit < enough:
            best = [_space(a, b, found.misfit) for a, b in zip(A, B, strict=True)]
            enough = 0.1 * found.misfit
        if found.misfit < _GOAL:
            break
    return best


def through_time(pulses: Floats) -> tuple[Floats, Floats]:
    """Sort answers to pulses in each step, [step of the pulse, age], by the step in which they are seen."""
    answers = np.stack([_later(pulses[:, q], q) for q in range(pulses.shape[1])], axis=1)
    return answers, np.stack([_younger(_later(answers, n), n) for n in range(1, _LARGEST_ORDER + 1)])


def held(pulses: Floats) -> tuple[Floats, Floats]:
    """Sort answers of an FMU that was asked again in each step, as it was there: [step, age]."""
    return pulses, np.stack([_younger(pulses, n) for n in range(1, _LARGEST_ORDER + 1)])


def _later(rows: Floats, n: int) -> Floats:
    moved = np.zeros_like(rows)
    moved[n:] = rows[: len(rows) - n]
    return moved


def _younger(answers: Floats, n: int) -> Floats:
    moved = np.zeros_like(answers)
    moved[:, n:] = answers[:, :-n]
    return moved


def _positive(values: Floats) -> Floats:
    return np.where(values > 0.0, values, 1.0)


class _Coefficients(NamedTuple):
    """A (lag, ticks, outputs, outputs), B (lag, ticks, outputs, inputs), and the largest misfit."""

    A: Floats
    B: Floats
    misfit: float


def _coefficients(answers: Floats, earlier: Floats) -> _Coefficients:
    n, ticks, p = len(earlier), answers.shape[0], answers.shape[2]
    rows = earlier[:, :, n + 1 :].transpose(1, 2, 4, 0, 3).reshape(ticks, -1, n * p)
    sides = answers[:, n + 1 :].transpose(0, 1, 3, 2).reshape(ticks, -1, p)
    found = np.linalg.pinv(rows, rcond=_SMALLEST) @ sides
    misfit = float(np.max(np.abs(rows @ found - sides), initial=0.0))
    A = found.reshape(ticks, n, p, p).transpose(1, 0, 3, 2)
    free = answers[:, : n + 1] - np.einsum("lkij,lkqjm->kqim", A, earlier[:, :, : n + 1])
    return _Coefficients(A, free.transpose(1, 0, 2, 3), misfit)


def _space(A: Floats, B: Floats, misfit: float) -> StateSpace:
    """Put the coefficients of one tick, A (lag, p, p), B (lag, p, m), over the state (y(k-1).., u(k-1)..)."""
    n, p, m = len(A), A.shape[1], B.shape[2]
    C = np.concatenate([*A, *B[1:]], axis=1)
    order = n * (p + m)
    shift, enter = np.zeros((order, order)), np.zeros((order, m))
    shift[p : n * p, : (n - 1) * p] = np.eye((n - 1) * p)
    shift[n * p + m :, n * p : -m] = np.eye((n - 1) * m)
    shift[:p] = C
    enter[:p], enter[n * p : n * p + m] = B[0], np.eye(m)
    return StateSpace(shift, enter, C, B[0], np.zeros((order, 0)), misfit)

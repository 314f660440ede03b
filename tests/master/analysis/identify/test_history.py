"""Linear systems that vary with time, found from their answers to pulses."""

from __future__ import annotations

import numpy as np
import pytest

from master.analysis.closed_loop.tick_matrix import LinearPart
from master.analysis.identify.history import AGES, held, systems, through_time
from master.analysis.state_space import StateSpace

TICKS = 90
INPUTS = 2


def matrices(k):
    """An oscillator whose stiffness swings; two inputs, outputs of very different size."""
    swing = 1.0 + 0.3 * np.sin(0.11 * k)
    A = np.array([[1.0, 0.1], [-0.2 * swing, 0.95]])
    B = np.array([[0.0, 0.02], [0.3 * swing, 0.0]])
    C = np.array([[2.0e4, 1.0e3 * swing]])
    return A, B, C, np.array([[10.0, 0.0]])


def run(u, matrices_of=matrices):
    x, rows = np.zeros(2), []
    for k, value in enumerate(u):
        A, B, C, D = matrices_of(k)
        rows.append(C @ x + D @ value)
        x = A @ x + B @ value
    return np.array(rows)


def pulses(step, matrices_of=matrices, ticks=TICKS + AGES):
    found = np.zeros((AGES, 1, INPUTS))
    for i in range(INPUTS):
        u = np.zeros((ticks, INPUTS))
        u[step, i] = 1.0
        found[:, :, i] = run(u, matrices_of)[step : step + AGES]
    return found


def answer(found, u):
    x, rows = np.zeros(found[0].order), []
    for system, value in zip(found, u, strict=True):
        rows.append(system.C @ x + system.D @ value)
        x = system.A @ x + system.B @ value
    return np.array(rows)


def test_a_system_that_varies_answers_as_it_did():
    found = systems(*through_time(np.array([pulses(k) for k in range(TICKS)])))
    u = np.random.default_rng(1).normal(size=(TICKS, INPUTS))

    assert found[0].order == 2 * (1 + INPUTS)  # two last outputs, two last inputs: the oscillator's order
    assert answer(found, u) == pytest.approx(run(u), abs=1e-7 * np.max(np.abs(run(u))))


def test_a_system_asked_while_it_is_held_gives_its_coefficients():
    """Those of the autoregressive law y(k) = a y(k-1) + b y(k-2) + u(k-1)."""
    a, b = 1.9, -0.95

    def law(k):
        return (
            np.array([[a, b], [1.0, 0.0]]),
            np.array([[1.0, 0.0], [0.0, 0.0]]),
            np.array([[1.0, 0.0]]),
            ZERO,
        )

    found = systems(*held(np.array([pulses(0, law)] * 3)))

    assert [found[2].C[0, 0], found[2].C[0, 1]] == pytest.approx([a, b])
    assert found[2].C[0, 2:4] == pytest.approx([1.0, 0.0], abs=1e-9)


ZERO = np.zeros((1, INPUTS))


def test_what_comes_again_comes_again():
    def system(value):
        return StateSpace(np.full((1, 1), value), *(np.zeros((1, 1)),) * 4, 0.0)

    part = LinearPart(system(0.0), ("a.u",), ("a.y",), [system(float(k)) for k in range(5)], repeats=3)

    assert [part.at(k).A[0, 0] for k in range(10)] == [0, 1, 2, 3, 4, 2, 3, 4, 2, 3]
    assert LinearPart(system(7.0), (), ()).at(12).A[0, 0] == 7.0

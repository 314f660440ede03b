"""A realisation answers as the system did that it was made from."""

from __future__ import annotations

import numpy as np
import pytest

from master.analysis.identify.realisation import GOAL, realise
from master.analysis.identify.responses import N_STEPS, Responses


def responses_of(A, B, C, D, X0=None):
    """Answers of x+ = A x + B u, y+ = C x + D u."""
    X0 = np.zeros((len(A), 0)) if X0 is None else X0
    pulses, free, x, x0 = [D], [], B, X0
    for _ in range(N_STEPS):
        pulses.append(C @ x)
        free.append(C @ x0)
        x, x0 = A @ x, A @ x0
    return Responses(np.array(pulses[:N_STEPS]), np.array(free), 0.0)


def eigenvalues(A):
    return np.sort_complex(np.linalg.eigvals(A).astype(complex))


def test_poles_order_and_feedthrough_are_found_over_five_decades_of_gain():
    A = np.diag([0.999, 0.97, 0.5])
    B, C = np.array([[1.0, 0.0], [0.0, 3e5], [1.0, 1.0]]), np.array([[1.0, 2e-3, 1.0], [5e4, 0.0, 2.0]])
    D = np.array([[0.0, 1.0], [2.0, 0.0]])

    found = realise(responses_of(A, B, C, D))

    assert found.order == 3
    assert eigenvalues(found.A) == pytest.approx(eigenvalues(A), abs=1e-7)
    np.testing.assert_array_equal(found.D, D)
    assert found.misfit < GOAL


def test_a_double_integrator_is_found():
    A, B, C = np.array([[1.0, 1.0], [0.0, 1.0]]), np.array([[1.0], [1.0]]), np.array([[1.0, 0.0]])

    found = realise(responses_of(A, B, C, np.zeros((1, 1))))

    assert found.order == 2
    assert eigenvalues(found.A) == pytest.approx([1.0, 1.0], abs=1e-4)


@pytest.mark.parametrize("ticks", [1, 20, 100])
def test_a_dead_time_becomes_a_line_of_that_many_states(ticks):
    A, B, C = np.eye(ticks, k=-1), np.eye(ticks, 1), np.eye(1, ticks, ticks - 1)

    found = realise(responses_of(A, B, C, np.zeros((1, 1))))

    assert found.order == ticks
    assert found.misfit < GOAL


def test_what_only_a_start_value_excites_is_found():
    A, nothing = np.diag([0.9, 0.8]), np.zeros((2, 0))

    found = realise(responses_of(A, nothing, np.ones((1, 2)), np.zeros((1, 0)), X0=np.ones((2, 1))))

    assert eigenvalues(found.A) == pytest.approx([0.8, 0.9])


def test_noise_of_the_answers_does_not_become_states():
    A, B, C = np.diag([0.99, 0.9]), np.ones((2, 1)), np.ones((1, 2))
    clean = responses_of(A, B, C, np.zeros((1, 1)))
    noise = 1e-7 * np.random.default_rng(1).standard_normal(clean.pulses.shape)

    found = realise(Responses(clean.pulses + noise, clean.free, 0.0))

    assert found.order == 2
    assert eigenvalues(found.A) == pytest.approx([0.9, 0.99], abs=1e-5)


def test_no_input_and_no_start_value_gives_no_states():
    empty = np.zeros((N_STEPS, 1, 0))

    assert realise(Responses(empty, empty, 0.0)).order == 0

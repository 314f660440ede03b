"""Laws with states, recognised as linear by asking them, and answered for a whole signal."""

from __future__ import annotations

import numpy as np
import pytest

from master.diagnosis.numerics.linear_memory import Rates, linear_memory

PERIOD = 0.01
T = PERIOD * np.arange(400)
TAU = 0.2


def lag(states, inputs):
    return Rates(states[0], (inputs[0] - states) / TAU)


def mode(states, inputs):
    w = 2.0 * np.pi * 3.0
    return Rates(states[0] + inputs[0], np.stack([states[1], w * w * (inputs[1] - states[0])]))


def test_a_lag_follows_a_ramp_exactly():
    """T x' = u - x with u = t and x(0) = 2: x = t - T + (2 + T) exp(-t/T)."""
    memory = linear_memory(lag, np.ones(1), np.ones(1))

    assert memory is not None
    answer = memory.answer(np.array([2.0]), T[None, :], PERIOD)
    assert answer == pytest.approx(T - TAU + (2.0 + TAU) * np.exp(-T / TAU), abs=1e-9)


def test_a_mode_without_damping_answers_to_both_of_its_inputs():
    """X'' = w^2 (1 - x) from rest: x = 1 - cos w t; the other input passes at once."""
    memory = linear_memory(mode, np.array([1.0, 20.0]), np.ones(2))

    assert memory is not None
    answer = memory.answer(np.zeros(2), np.stack([np.sin(T), np.ones(len(T))]), PERIOD)
    assert answer == pytest.approx(np.sin(T) + 1.0 - np.cos(6.0 * np.pi * T), abs=1e-9)


@pytest.mark.parametrize(
    "law",
    [
        lambda x, u: Rates(x[0], np.clip(u[0] - x, -2.0, 2.0)),
        lambda x, u: Rates(x[0], u[0] - np.abs(u[0]) * x),
        lambda x, u: Rates(x[0] + 1.0, u[0] - x),
        lambda x, u: Rates(x[0], (u[0] - x) / 0.0),
    ],
    ids=["clipped", "friction", "a constant is added", "not finite"],
)
def test_what_is_not_linear_about_zero_is_no_linear_law(law):
    with np.errstate(all="ignore"):
        assert linear_memory(law, np.ones(1), np.ones(1)) is None

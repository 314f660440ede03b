"""Laws that are linear in their coefficients: their functions of time, answers to them, the regression."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from master.diagnosis.numerics.memory import lagged, plays
from master.diagnosis.numerics.regression import penalised
from master.diagnosis.numerics.step_answers import convolved
from master.diagnosis.replay.placed_effect import PlacedEffect
from master.diagnosis.unnamed_law.describe import describe
from master.diagnosis.unnamed_law.fit import penalty_matrix
from master.diagnosis.unnamed_law.shapes import Law

H, T_F = 1e-3, 0.05
T = np.arange(3000) * H


def test_answer_to_a_sine_is_that_of_the_lag():
    """T_f y' + y = sin w t from rest: y = (sin(w t - phi) + sin(phi) exp(-t/T_f)) cos(phi)."""
    w = 20.0
    step = 1.0 - np.exp(-T / T_F)

    found = convolved(step, np.sin(w * T)[:, None])[:, 0]

    phi = np.arctan(w * T_F)
    exact = (np.sin(w * T - phi) + np.sin(phi) * np.exp(-T / T_F)) * np.cos(phi)
    assert np.abs(found - exact).max() < (w * H) ** 2  # linear between samples


def test_answer_without_memory_is_the_function_itself():
    values = np.random.default_rng(1).standard_normal((50, 2))

    assert np.array_equal(convolved(np.full(50, 3.0), values), 3.0 * values)


def test_lagged_value_of_a_ramp_is_behind_by_its_time_constant():
    found = lagged(2.0 * T, H / T_F)

    assert found[-1] == pytest.approx(2.0 * (T[-1] - T_F), abs=1e-5)  # (H/T_F)^2/12 of a step
    assert lagged(np.full(10, 4.0), H / T_F) == pytest.approx(np.full(10, 4.0))


def test_play_is_carried_along_and_stays_behind():
    found = plays(np.array([0.0, 1.0, 3.0, 2.0, -2.0]), np.array([0.5, 2.0]))

    assert found.T.tolist() == [[0.0, 0.5, 0.5, -0.5, -0.5], [0.0, 1.0, 2.0, 1.0, -2.0]]


def law(effect, names):
    return Law(PlacedEffect("contact", "rope_force", effect), {}, names)


def test_rough_penalty_leaves_a_straight_line():
    rng = np.random.default_rng(2)
    names = tuple(f"c_{i}" for i in range(42))
    wanted = np.concatenate([0.1 * np.arange(21) + 0.5, np.zeros(21)])
    matrix = rng.standard_normal((400, 1, 42))
    left = matrix @ wanted + 0.5 * rng.standard_normal((400, 1))

    penalty = penalty_matrix(law("learned_position_velocity", names), matrix, 1e5, np.zeros(0))
    found = penalised(matrix, left, penalty, np.zeros(42))

    assert np.abs(np.diff(found[:21], 2)).max() < 1e-3
    assert found == pytest.approx(wanted, abs=0.1)


@pytest.mark.parametrize(
    ("effect", "c", "words"),
    [
        (
            "learned_position_velocity",
            lambda i: i - 10.0,
            "smooth law of position in contact.rope_force, odd",
        ),
        ("learned_position_velocity", lambda i: (i - 10.0) ** 2, "even"),
        ("learned_time_position", lambda i: 1.0, "changes with time"),
        ("learned_plays_position", lambda i: 1.0, "memory of the position"),
    ],
)
def test_shape_is_said_in_words(effect, c, words):
    n = {"learned_plays_position": 10}.get(effect, 21)
    placed = PlacedEffect("contact", "rope_force", effect)
    values = {placed.variable(f"c_{i + 1}"): c(i) for i in range(n)}
    values |= {placed.variable(f"d_{i + 1}"): 0.0 for i in range(n)}

    assert words in describe(placed, values)


def test_functions_of_a_law_are_laid_out_by_recording():
    placed = PlacedEffect("contact", "guide_force", "learned_position_sign")
    fixed = {placed.variable("half_range_a"): 1.0, placed.variable("half_range_b"): 0.1}
    bench = SimpleNamespace(
        recordings={"a": range(3), "b": range(2)},
        first_sample={"a": 0, "b": 3}.get,
        times=H * np.array([0.0, 1.0, 2.0, 0.0, 1.0]),
        period=H,
    )
    study = SimpleNamespace(bench=bench)
    signals = {"value": np.zeros(5), "position": np.linspace(-1, 1, 5), "velocity": np.full(5, 9.0)}

    found = Law(placed, fixed, ()).functions(study, signals)

    assert found.shape == (5, 42)
    assert found[:, :21].sum(axis=1) == pytest.approx(np.ones(5))
    assert found[:, 21:] == pytest.approx(found[:, :21])

"""The fit finds the parameters of a plant that has the form; the design repeats the paper's equations."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.linalg import expm

from master.analysis.state_space import StateSpace
from master.docking.phase_lead import Design, dynamics_frequency
from master.docking.plant import STEP_SIZE, ThirdOrder, fit, judge

PLANT = ThirdOrder(30.0, 125.66370614359172, 0.8, 0.002)


def held_plant(form, ticks):
    """Exact discrete form of the third order, the command held and `ticks` late."""
    w2 = form.w_v**2
    A = np.zeros((4, 4))
    A[0, 1] = A[1, 2] = 1.0
    A[2] = [-form.K_p * w2, -w2, -2.0 * form.z * form.w_v, form.K_p * w2]
    M = expm(A * STEP_SIZE)
    n = 3 + ticks
    F, G = np.zeros((n, n)), np.zeros((n, 1))
    F[:3, :3], F[:3, 3] = M[:3, :3], M[:3, 3]
    F[3:-1, 4:] = np.eye(ticks - 1)
    G[-1] = 1.0
    C = F[:1]
    return StateSpace(F, G, C, np.zeros((1, 1)), np.zeros((n, 0)), 0.0)


def test_the_fit_finds_the_parameters_of_a_plant_of_the_form():
    found = fit(held_plant(PLANT, 2), ThirdOrder(20.0, 90.0, 1.0, 0.001)).form

    assert found.K_p == pytest.approx(PLANT.K_p, rel=1e-4)
    assert found.w_v == pytest.approx(PLANT.w_v, rel=1e-3)
    assert found.z == pytest.approx(PLANT.z, rel=1e-3)
    assert found.dead_time == pytest.approx(PLANT.dead_time, abs=1e-6)


def test_a_tick_of_dead_time_too_much_shows_as_its_phase():
    found = judge(held_plant(PLANT, 3), PLANT)

    assert found.phase_error == pytest.approx(360.0 * 5.0 * STEP_SIZE, rel=1e-3)
    assert found.magnitude_error < 1e-4


@pytest.mark.parametrize(
    ("values", "frequency"),
    [
        ((820.0, 80.0, 150000.0, 37900.0), 0.9648),
        ((1000.0, 60.0, 800000.0, 400000.0), 2.590),
        ((4000.0, 100.0, 139200.0, 37760.0), 0.4335),
        ((1000.0, 100.0, 139200.0, 37760.0), 0.8654),
    ],
)
def test_dynamics_frequency_of_equation_3(values, frequency):
    assert dynamics_frequency(*values) == pytest.approx(frequency, abs=5e-4)


@pytest.mark.parametrize(
    ("phase_deg", "frequency", "alpha", "time_constant", "K"),
    [(12.39, 0.9746, 1.546, 0.1313, 0.804), (33.20, 2.617, 3.421, 0.0329, 0.541)],
)
@pytest.mark.parametrize("gain", [1.0, 1.1])
def test_lead_of_equations_23_and_24(phase_deg, frequency, alpha, time_constant, K, gain):
    nothing = np.zeros(1)
    found = Design(math.radians(phase_deg), frequency, gain, nothing, nothing, nothing)

    assert found.alpha == pytest.approx(alpha, abs=2e-3)
    assert found.time_constant == pytest.approx(time_constant, abs=1e-4)
    assert found.gain_at_rest == pytest.approx(gain * K, abs=1e-3)

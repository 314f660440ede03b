"""
The paper's claims on the FMUs as `dockloop run` steps them: issue 2's table.

Bounds are those of the independent computation in the project's physics reference, section 8; the
reference motion's frequency and damping are eigenvalues of the matrix written here.
"""

from functools import cache
from pathlib import Path

import numpy as np
import pytest

from master.experiment import Request, prepare
from master.results.metrics import compute_metrics
from master.simulation import RunOptions, simulate

CONFIGS = Path(__file__).parents[2] / "configs"
SIMULATIONS = ("low_frequency", "high_frequency")
EXPERIMENTS = ("experiment", "experiment_1000kg")
ALL_ON = {**dict.fromkeys(SIMULATIONS, "cfdc_dpdc"), **dict.fromkeys(EXPERIMENTS, "all")}
FORCE = {**dict.fromkeys(SIMULATIONS, "cfdc"), **dict.fromkeys(EXPERIMENTS, "cfdc_fmdc")}
EXACT, F, L = "identifier=fixed", "preset=F", "preset=L"


@cache
def metrics(config, variant, *compensator):
    assignments = tuple(f"compensator.{c}" for c in compensator)
    experiment = prepare(CONFIGS / f"{config}.yaml", Request(variant=variant, assignments=assignments))
    options = RunOptions(limits=experiment.limits)
    outcome = simulate(experiment.system, experiment.schedule, experiment.grid, options=options)
    return compute_metrics(outcome.result, experiment.config.compare)


@pytest.mark.parametrize(
    ("config", "bound"),
    [("low_frequency", 1.7), ("high_frequency", 3.0), ("experiment", 1.3), ("experiment_1000kg", 1.8)],
)
def test_without_compensation_the_loop_grows(config, bound):
    assert metrics(config, "none")["growth_per_cycle"] > bound


@pytest.mark.parametrize("config", SIMULATIONS + EXPERIMENTS)
@pytest.mark.parametrize(("tuning", "bound"), [(EXACT, 0.01), (F, 0.01), (L, 0.03)])
def test_force_compensation_gives_the_motion_of_the_real_docking(config, tuning, bound):
    found = metrics(config, FORCE[config], tuning)

    assert abs(found["zeta"] - found["zeta_reference"]) < 5e-4
    assert found["rms_s_des"] < bound


@pytest.mark.parametrize("config", SIMULATIONS + EXPERIMENTS)
@pytest.mark.parametrize(("tuning", "phase"), [(EXACT, 1.0), (F, 1.0), (L, 2.0)])
def test_all_methods_together_reproduce_it(config, tuning, phase):
    found = metrics(config, ALL_ON[config], tuning)

    assert found["rms_s_act"] < 0.03
    assert abs(found["phase_deg"]) < phase


@pytest.mark.parametrize("config", EXPERIMENTS)
@pytest.mark.parametrize("tuning", [EXACT, F])
def test_contact_force_compensation_alone_only_slows_the_growth(config, tuning):
    assert (
        1.04
        < metrics(config, "cfdc", tuning)["growth_per_cycle"]
        < metrics(config, "none")["growth_per_cycle"]
    )


@pytest.mark.parametrize("config", EXPERIMENTS)
def test_force_measurement_compensation_alone_only_slows_the_growth(config):
    assert 1.0 < metrics(config, "fmdc")["growth_per_cycle"] < metrics(config, "none")["growth_per_cycle"]


def test_the_kalman_filter_follows_a_stiffness_that_varies():
    assert metrics("time_varying_stiffness", "cfdc")["rms_s_des"] < 0.03


@pytest.mark.parametrize("factor", [0.9, 0.95, 0.98, 0.99, 0.995, 0.998, 1.0])
def test_recursive_least_squares_does_not_follow_it(factor):
    assert metrics("time_varying_stiffness", "rls", f"forgetting_factor={factor}")["rms_s_des"] > 0.08


def poles(m_s, m_e, k_m, c_m, k_p, c_p):
    """Eigenvalues of Fig. 4: m_s s'' = -k_m x_e - c_m x_e', m_e x_e'' of Eq. 7 with s_act = s."""
    k, c = k_m + k_p, c_m + c_p
    matrix = [
        [0, 1, 0, 0],
        [0, 0, -k_m / m_s, -c_m / m_s],
        [0, 0, 0, 1],
        [k_p / m_e, c_p / m_e, -k / m_e, -c / m_e],
    ]
    return np.linalg.eigvals(np.array(matrix, dtype=float))


@pytest.mark.parametrize(
    ("config", "parameters"),
    [
        ("low_frequency", (820, 80, 150000, 158, 37900, 65)),
        ("high_frequency", (1000, 60, 800000, 800, 400000, 400)),
        ("experiment", (4000, 100, 139200, 136.1, 37760, 97.3)),
        ("experiment_1000kg", (1000, 100, 139200, 136.1, 37760, 97.3)),
    ],
)
def test_the_reference_has_the_eigenvalues_of_its_matrix(config, parameters):
    slow = min(poles(*parameters), key=lambda s: (abs(s), -s.imag))
    found = metrics(config, FORCE[config], EXACT)

    assert found["zeta_reference"] == pytest.approx(-slow.real / abs(slow), abs=1e-6)
    assert found["frequency_reference"] == pytest.approx(abs(slow.imag) / (2 * np.pi), rel=1e-6)

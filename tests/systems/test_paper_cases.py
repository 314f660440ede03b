"""
The paper's claims on the FMUs as `dockloop run` steps them, with the linear plant and with the hexapod.

Bounds are those of the independent computation in the project's physics reference, section 8, the same for
both plants; the reference motion's frequency and damping are eigenvalues of the matrix written here.
"""

from functools import cache

import numpy as np
import pytest

from tests.systems.analysed import simulated

SIMULATIONS = ("low_frequency", "high_frequency")
EXPERIMENTS = ("experiment", "experiment_1000kg")
CASES = SIMULATIONS + EXPERIMENTS
ALL_ON = {**dict.fromkeys(SIMULATIONS, "cfdc_dpdc"), **dict.fromkeys(EXPERIMENTS, "all")}
FORCE = {**dict.fromkeys(SIMULATIONS, "cfdc"), **dict.fromkeys(EXPERIMENTS, "cfdc_fmdc")}
EXACT, F, L = "identifier=fixed", "preset=F", "preset=L"
VARYING = "time_varying_stiffness"
FACTORS = (0.9, 0.95, 0.98, 0.99, 0.995, 0.998, 1.0)

pytestmark = pytest.mark.parametrize("plant", ["linear", "hexapod"])


@cache
def metrics(plant, config, variant, *compensator):
    name = config if plant == "linear" else f"{plant}/{config}"
    return simulated(name, variant, *(f"compensator.{value}" for value in compensator))


@pytest.mark.parametrize(
    ("config", "bound"),
    [
        ("low_frequency", 1.7),
        ("high_frequency", 3.0),
        (VARYING, 3.0),
        ("experiment", 1.3),
        ("experiment_1000kg", 1.8),
    ],
)
def test_without_compensation_the_loop_grows(plant, config, bound):
    assert metrics(plant, config, "none").growth_per_cycle > bound


@pytest.mark.parametrize("config", [*SIMULATIONS, VARYING])
def test_without_sensor_lag_the_phase_lead_alone_stops_it(plant, config):
    found = metrics(plant, config, "dpdc")

    assert found.status == "completed"
    assert found.growth_per_cycle < 1.0


@pytest.mark.parametrize("config", CASES)
@pytest.mark.parametrize(("tuning", "bound"), [(EXACT, 0.01), (F, 0.01), (L, 0.03)])
def test_force_compensation_gives_the_motion_of_the_real_docking(plant, config, tuning, bound):
    found = metrics(plant, config, FORCE[config], tuning)

    assert abs(found.zeta - found.zeta_reference) < 5e-4
    assert found.rms_s_des < bound


PLANT_LAG = {  # deg at the loop's frequency, the hexapod's with the hold of its command
    "linear": {
        "low_frequency": -12.39,
        "high_frequency": -33.20,
        "experiment": -5.53,
        "experiment_1000kg": -11.13,
    },
    "hexapod": {
        "low_frequency": -12.45,
        "high_frequency": -31.45,
        "experiment": -5.61,
        "experiment_1000kg": -11.2,
    },
}


@pytest.mark.parametrize("config", CASES)
@pytest.mark.parametrize(("tuning", "within"), [(EXACT, 1.5), (F, 1.5), (L, 2.0)])
def test_force_compensation_leaves_the_plants_phase(plant, config, tuning, within):
    found = metrics(plant, config, FORCE[config], tuning)

    assert found.phase_deg == pytest.approx(PLANT_LAG[plant][config], abs=within)


@pytest.mark.parametrize("config", CASES)
@pytest.mark.parametrize(("tuning", "phase"), [(EXACT, 1.0), (F, 1.0), (L, 2.0)])
def test_all_methods_together_reproduce_it(plant, config, tuning, phase):
    found = metrics(plant, config, ALL_ON[config], tuning)

    assert abs(found.zeta - found.zeta_reference) < 5e-4
    assert found.rms_s_act < 0.03
    assert abs(found.phase_deg) < phase


@pytest.mark.parametrize("config", EXPERIMENTS)
@pytest.mark.parametrize("tuning", [EXACT, F])
def test_contact_force_compensation_alone_only_slows_the_growth(plant, config, tuning):
    slowed = metrics(plant, config, "cfdc", tuning).growth_per_cycle

    assert 1.04 < slowed < metrics(plant, config, "none").growth_per_cycle


@pytest.mark.parametrize("config", EXPERIMENTS)
def test_force_measurement_compensation_alone_only_slows_the_growth(plant, config):
    slowed = metrics(plant, config, "fmdc").growth_per_cycle

    assert 1.0 < slowed < metrics(plant, config, "none").growth_per_cycle


def test_the_kalman_filter_follows_a_stiffness_that_varies(plant):
    assert metrics(plant, VARYING, "cfdc").rms_s_des < 0.03
    assert metrics(plant, VARYING, "cfdc_dpdc").rms_s_act < 0.03


@pytest.mark.parametrize("factor", FACTORS)
def test_recursive_least_squares_does_not_follow_it(plant, factor):
    rls = metrics(plant, VARYING, "rls", f"forgetting_factor={factor}").rms_s_des

    assert rls > 0.08
    assert rls > 3.0 * metrics(plant, VARYING, "cfdc").rms_s_des
    assert rls > metrics(plant, VARYING, "cfdc", EXACT).rms_s_des


def test_the_phase_lead_does_not_make_up_for_least_squares(plant):
    assert metrics(plant, VARYING, "rls_dpdc").rms_s_act > 0.03


def test_the_papers_gain_falls_short_in_the_drag_and_unit_gain_does_not(plant):
    """K = 1/sqrt(alpha) = 0.80 scales a displacement that stands or grows steadily."""
    short, unit = (metrics(plant, "drag", variant) for variant in ("cfdc_dpdc", "unit_dc"))

    assert short.rms_s_act > 0.05
    assert unit.rms_s_act < 0.01


def test_in_the_drag_the_dynamics_are_those_of_the_real_docking(plant):
    for variant in ("cfdc", "cfdc_dpdc", "unit_dc"):
        assert metrics(plant, "drag", variant).rms_s_des < 0.01


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
def test_the_reference_has_the_eigenvalues_of_its_matrix(plant, config, parameters):
    slow = min(poles(*parameters), key=lambda s: (abs(s), -s.imag))
    found = metrics(plant, config, FORCE[config], EXACT)

    assert found.zeta_reference == pytest.approx(-slow.real / abs(slow), abs=1e-6)
    assert found.frequency_reference == pytest.approx(abs(slow.imag) / (2 * np.pi), rel=1e-6)

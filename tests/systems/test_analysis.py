"""Poles and margins of the coupled FMUs against their simulation and against independent numbers."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import yaml
from scipy.integrate import solve_ivp

from master.analysis.closed_loop.linearise import Linearisation
from master.analysis.measures.margins import margins
from master.analysis.measures.poles import growth_rate
from master.analysis.measures.sweep import parse_axis, stability_map
from master.reproduce.measures.poles import judged
from tests.costs import long_for
from tests.systems.analysed import CONFIGS, analysed, prepared, simulated

LINEAR = ("low_frequency", "high_frequency", "experiment", "experiment_1000kg")
VARYING = ("time_varying_stiffness", "hexapod/time_varying_stiffness")
SATURATES = ("hexapod/time_varying_stiffness", "none")
FIXED = "compensator.identifier=fixed"


def variants(name):
    return list(yaml.safe_load((CONFIGS / f"{name}.yaml").read_text())["variants"])


def cases(*names):
    return [(name, variant) for name in names for variant in variants(name)]


@pytest.mark.parametrize(("name", "variant"), cases(*LINEAR))
def test_damping_is_that_of_the_simulation_under_the_same_assumptions(name, variant):
    found = analysed(name, variant, FIXED).dominant
    run = simulated(name, variant, FIXED)

    assert found.zeta == pytest.approx(run.zeta, abs=2e-5)
    assert found.frequency == pytest.approx(run.frequency, rel=1e-3)


@pytest.mark.parametrize(("name", "variant"), cases(*(f"hexapod/{n}" for n in LINEAR)))
def test_damping_is_that_of_the_simulated_hexapod(name, variant):
    """An uncompensated run saturates the motors at the end: no more than the bound."""
    found = analysed(name, variant, FIXED).dominant
    run = simulated(name, variant, FIXED)

    assert found.zeta == pytest.approx(run.zeta, abs=5e-4)


@pytest.mark.parametrize(
    ("name", "variant"), cases(*LINEAR, "hexapod/experiment", "hexapod/experiment_1000kg")
)
def test_damping_is_that_of_the_simulation_with_the_kalman_filter(name, variant):
    """Without FMDC the filter learns the sensor's lag as well, and the damping hangs on it."""
    found = analysed(name, variant).dominant
    run = simulated(name, variant)

    assert found.zeta == pytest.approx(run.zeta, abs=2e-5)


VARYING_CASES = [case for case in cases(*VARYING) if case != SATURATES]


@pytest.mark.parametrize(("name", "variant"), long_for(VARYING_CASES[1:], VARYING_CASES))
def test_damping_under_varying_stiffness_is_that_of_the_run_whatever_identifies(name, variant):
    """Along the run the loop is linear to its noise: 1.3e-5 with RLS, whose parameters run far astray."""
    found = analysed(name, variant)
    run = simulated(name, variant)

    assert found.dominant.zeta == pytest.approx(run.zeta, abs=5e-5)
    assert found.dominant.frequency == pytest.approx(run.frequency, rel=1e-4)
    assert found.along.departure < 2e-3


def test_a_run_that_saturates_is_said_not_to_be_linear():
    """Two cycles in which the motors give out: no linear system has the damping of that run."""
    found, run = analysed(*SATURATES), simulated(*SATURATES)

    assert found.along.simulated.zeta == pytest.approx(run.zeta)
    assert found.along.nonlinear[0] == "motion_simulator"
    assert any(f"zeta of the run itself is {run.zeta:+.6f}" in note for note in found.notes)


@pytest.mark.long
def test_growth_over_a_period_is_that_of_the_real_docking():
    """Independent: the multipliers of its equations over 1 s, integrated to 1e-12; 5e-4 as for a pole."""
    assert analysed("time_varying_stiffness", "cfdc_dpdc").growth_rate == pytest.approx(
        fastest_multiplier(1000.0, 60.0, (8e5, 800.0), (4e5, 400.0)), abs=5e-4 * 16.44
    )


def fastest_multiplier(m_s, m_e, manipulator, rope):
    (k_m, c_m), (k_p, c_p) = manipulator, rope

    def motion(t, z):
        s, v, x, w = z
        k = k_p + 8e4 * np.sin(2.0 * np.pi * t)
        force = -k_m * x - c_m * w
        return [v, force / m_s, w, (force + k * (s - x) + c_p * (v - w)) / m_e]

    columns = [solve_ivp(motion, (0.0, 1.0), e, "DOP853", rtol=1e-12, atol=1e-14).y[:, -1] for e in np.eye(4)]
    return float(np.log(np.max(np.abs(np.linalg.eigvals(np.array(columns).T)))))


def test_what_the_filter_learns_of_the_lag_changes_the_damping():
    """E2 under CFDC alone: 9.8e-4 of damping lie between the assumed and the identified parameters."""
    learned, assumed = (analysed("experiment_1000kg", "cfdc", *a).dominant.zeta for a in ((), (FIXED,)))

    assert learned < assumed - 5e-4


@pytest.mark.parametrize("name", LINEAR)
def test_the_dominant_pole_under_compensation_is_that_of_the_real_docking(name):
    found = analysed(name)

    assert abs(found.dominant.s - found.reference.s) < 5e-4 * abs(found.reference.s)


@pytest.mark.parametrize(
    ("name", "bound"),
    [
        ("low_frequency", 1.61e-3),
        ("high_frequency", 1.23e-3),
        ("experiment", 2.24e-3),
        ("experiment_1000kg", 2.27e-3),
    ],
)
def test_force_compensation_alone_bears_a_sensor_lag_up_to(name, bound):
    linearisation = Linearisation(prepared(name, "cfdc"))
    found = stability_map(linearisation, parse_axis("force_sensor.T_f=1e-4:4e-3:3", linearisation.system))

    [(root, _)] = found.boundary
    assert root == pytest.approx(bound, abs=0.05e-3)


@pytest.mark.parametrize(
    ("name", "variant", "budget"),
    [
        ("low_frequency", "cfdc", 1.563e-3),
        ("high_frequency", "cfdc", 0.988e-3),
        ("experiment", "cfdc_fmdc", 2.230e-3),
        ("experiment_1000kg", "cfdc_fmdc", 2.213e-3),
    ],
)
def test_latency_budget_of_the_force_path(name, variant, budget):
    found = analysed(name, variant).latency_budget

    assert found.delay == pytest.approx(budget, abs=0.02e-3)
    assert found.target == "spacecraft.f"


@pytest.mark.parametrize(
    ("name", "variant"),
    [
        ("low_frequency", "cfdc_dpdc"),
        pytest.param("hexapod/experiment_1000kg", "all", marks=pytest.mark.long),
    ],
)
def test_whole_steps_around_each_delay_margin_are_stable_and_unstable(name, variant):
    linearisation = Linearisation(prepared(name, variant))
    coupled = linearisation.coupled()
    bounded = [m for m in margins(coupled) if m.delay is not None]

    assert len(bounded) >= 5
    for margin in bounded:
        ticks = int(margin.delay / coupled.step_size)
        assert growth_rate(linearisation.coupled(extra={margin.target: ticks})) < 0.0
        assert growth_rate(linearisation.coupled(extra={margin.target: ticks + 1})) > 0.0


def test_forward_difference_has_an_unstable_second_mode():
    """Independent: +0.034 1/s at 48 rad/s, +0.105 1/s at 140 rad/s."""
    for name, growth, frequency in (("low_frequency", 0.034, 7.65), ("high_frequency", 0.105, 22.3)):
        found = analysed(name, "cfdc", FIXED, "compensator.difference_method=forward")

        worst = found.poles[0]
        assert worst.s.real == pytest.approx(growth, rel=0.15)
        assert worst.frequency == pytest.approx(frequency, rel=0.02)
        assert found.dominant.zeta > 0.0


@pytest.mark.parametrize("flavour", long_for(["python"], ["python", "fmi3"]))
def test_every_flavour_gives_the_same_poles(flavour):
    from master.analysis.summary import analyse
    from master.api import prepare_to_run
    from master.experiment.prepare import Request

    request = Request(variant="cfdc_dpdc", flavour=flavour)
    found = analyse(prepare_to_run(CONFIGS / "low_frequency.yaml", request)).dominant

    assert found.s == pytest.approx(analysed("low_frequency", "cfdc_dpdc").dominant.s, rel=1e-6)


def test_a_delay_and_a_rate_each_have_their_own_poles():
    """Nothing else differs: neither name, nor parameters, nor the groups of the order."""
    plain = prepared("low_frequency", "none", FIXED)
    wires = tuple(replace(w, delay=2) if w.target.name == "spacecraft.f" else w for w in plain.system.wires)
    delayed = replace(plain, system=replace(plain.system, wires=wires))
    instances = plain.system.instances
    system = replace(plain.system, instances={**instances, "ideal": replace(instances["ideal"], every=2)})
    schedule = replace(plain.schedule, every={**plain.schedule.every, "ideal": 2})
    slower = replace(plain, system=system, schedule=schedule)

    assert judged(delayed).fastest > judged(plain).fastest + 1e-3
    assert judged(slower).reference.period == 2.0 * judged(plain).reference.period
    assert judged(slower).reference.zeta == pytest.approx(judged(plain).reference.zeta, rel=0.05)

"""Poles and margins of the coupled FMUs against their simulation and against independent numbers."""

from __future__ import annotations

import pytest
import yaml
from analysed import CONFIGS, analysed, prepared, simulated

from master.analysis.laboratory import Laboratory
from master.analysis.margins import margins
from master.analysis.poles import growth_rate
from master.analysis.sweep import parse_axis, stability_map

LINEAR = ("low_frequency", "high_frequency", "experiment", "experiment_1000kg", "time_varying_stiffness")
FIXED = "compensator.identifier=fixed"
CONSTANT = ("contact.k_p_amplitude=0", "ideal.k_p_amplitude=0")
RISES_TO_THE_DRAG = ("drag", "hexapod/drag")


def variants(name):
    return list(yaml.safe_load((CONFIGS / f"{name}.yaml").read_text())["variants"])


def cases(*names):
    return [(name, variant) for name in names for variant in variants(name)]


@pytest.mark.parametrize(("name", "variant"), cases(*LINEAR))
def test_damping_is_that_of_the_simulation_under_the_same_assumptions(name, variant):
    found = analysed(name, variant, FIXED).dominant
    run = simulated(name, variant, FIXED, *CONSTANT)

    assert found.zeta == pytest.approx(run.zeta, abs=2e-5)
    assert found.frequency == pytest.approx(run.frequency, rel=1e-3)


@pytest.mark.parametrize(("name", "variant"), cases(*(f"hexapod/{n}" for n in LINEAR)))
def test_damping_is_that_of_the_simulated_hexapod(name, variant):
    """An uncompensated run saturates the motors at the end: no more than the bound."""
    found = analysed(name, variant, FIXED).dominant
    run = simulated(name, variant, FIXED, *CONSTANT)

    assert found.zeta == pytest.approx(run.zeta, abs=5e-4)


@pytest.mark.parametrize(
    ("name", "variant"), cases(*LINEAR[:-1], "hexapod/experiment", "hexapod/experiment_1000kg")
)
def test_damping_is_that_of_the_simulation_with_the_kalman_filter(name, variant):
    """Without FMDC the filter learns the sensor's lag as well, and the damping hangs on it."""
    found = analysed(name, variant).dominant
    run = simulated(name, variant)

    assert found.zeta == pytest.approx(run.zeta, abs=2e-5)


def test_what_the_filter_learns_of_the_lag_changes_the_damping():
    """E2 under CFDC alone: 9.8e-4 of damping lie between the assumed and the identified parameters."""
    learned, assumed = (analysed("experiment_1000kg", "cfdc", *a).dominant.zeta for a in ((), (FIXED,)))

    assert learned < assumed - 5e-4


@pytest.mark.parametrize("name", LINEAR[:-1])
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
    laboratory = Laboratory(prepared(name, "cfdc"))
    found = stability_map(laboratory, parse_axis("force_sensor.T_f=1e-4:4e-3:3", laboratory.system))

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
    ("name", "variant"), [("low_frequency", "cfdc_dpdc"), ("hexapod/experiment_1000kg", "all")]
)
def test_whole_steps_around_each_delay_margin_are_stable_and_unstable(name, variant):
    laboratory = Laboratory(prepared(name, variant))
    coupled = laboratory.coupled()
    bounded = [m for m in margins(coupled) if m.delay is not None]

    assert len(bounded) >= 5
    for margin in bounded:
        ticks = int(margin.delay / coupled.step_size)
        assert growth_rate(laboratory.coupled(extra={margin.target: ticks})) < 0.0
        assert growth_rate(laboratory.coupled(extra={margin.target: ticks + 1})) > 0.0


def test_forward_difference_has_an_unstable_second_mode():
    """Independent: +0.034 1/s at 48 rad/s, +0.105 1/s at 140 rad/s."""
    for name, growth, frequency in (("low_frequency", 0.034, 7.65), ("high_frequency", 0.105, 22.3)):
        found = analysed(name, "cfdc", FIXED, "compensator.difference_method=forward")

        worst = found.poles[0]
        assert worst.s.real == pytest.approx(growth, rel=0.15)
        assert worst.frequency == pytest.approx(frequency, rel=0.02)
        assert found.dominant.zeta > 0.0


@pytest.mark.parametrize("flavour", ["python", "fmi3"])
def test_every_flavour_gives_the_same_poles(flavour):
    from master.analysis.summary import analyse
    from master.experiment import Request, prepare

    request = Request(variant="cfdc_dpdc", flavour=flavour)
    found = analyse(prepare(CONFIGS / "low_frequency.yaml", request)).dominant

    assert found.s == pytest.approx(analysed("low_frequency", "cfdc_dpdc").dominant.s, rel=1e-6)

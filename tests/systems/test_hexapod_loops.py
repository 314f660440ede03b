"""The paper's cases with the hexapod in the loop: the verdicts of the linear plant."""

from __future__ import annotations

import pytest
from analysed import simulated

PRESETS = ("F", "L")


def with_preset(name, variant, preset):
    return simulated(f"hexapod/{name}", variant, f"compensator.preset={preset}")


@pytest.mark.parametrize("preset", PRESETS)
def test_experiment_at_1000_kg(preset):
    none, fmdc, cfdc, both, all_ = (
        with_preset("experiment_1000kg", variant, preset)
        for variant in ("none", "fmdc", "cfdc", "cfdc_fmdc", "all")
    )

    assert none.zeta < -0.09
    assert fmdc.zeta < -0.07
    assert cfdc.zeta < -0.01
    assert both.zeta == pytest.approx(both.zeta_reference, abs=1e-3)
    assert all_.zeta == pytest.approx(all_.zeta_reference, abs=1e-3)
    assert all_.rms_s_act < 0.03
    assert abs(all_.phase_deg) < 2.0


@pytest.mark.parametrize(
    ("name", "least"),
    [("low_frequency", 1.7), ("high_frequency", 3.0), ("experiment", 1.3), ("experiment_1000kg", 1.8)],
)
def test_without_compensation_it_grows_and_stops_as_diverged_before_a_leg_does(name, least):
    found = simulated(f"hexapod/{name}", "none")

    assert found.growth_per_cycle > least
    assert found.status == "completed" if name == "experiment" else "diverged"


@pytest.mark.parametrize("preset", PRESETS)
@pytest.mark.parametrize(
    ("name", "variant", "lag"),
    [
        ("low_frequency", "cfdc", -12.45),
        ("high_frequency", "cfdc", -31.45),
        ("experiment", "cfdc_fmdc", -5.61),
        ("experiment_1000kg", "cfdc_fmdc", -11.2),
    ],
)
def test_force_compensation_stops_it_and_leaves_the_plants_phase(name, variant, lag, preset):
    """The lag is that of the hexapod at the loop's frequency, with dead time and hold."""
    found = with_preset(name, variant, preset)

    assert found.zeta == pytest.approx(found.zeta_reference, abs=5e-4)
    assert found.phase_deg == pytest.approx(lag, abs=1.5)
    assert found.rms_s_des < 0.03


@pytest.mark.parametrize("preset", PRESETS)
@pytest.mark.parametrize(
    ("name", "variant", "rms"),
    [
        ("low_frequency", "cfdc_dpdc", 0.03),
        ("high_frequency", "cfdc_dpdc", 0.05),
        ("experiment", "all", 0.03),
    ],
)
def test_all_together_coincide(name, variant, rms, preset):
    """At 2.6 Hz the hexapod passes 91 % of the motion, and the paper's K undoes the lead's gain only."""
    found = with_preset(name, variant, preset)

    assert found.zeta == pytest.approx(found.zeta_reference, abs=5e-4)
    assert abs(found.phase_deg) < 1.0
    assert found.rms_s_act < rms


def test_force_measurement_compensation_alone_only_slows_it():
    none, fmdc, cfdc = (simulated("hexapod/experiment", variant) for variant in ("none", "fmdc", "cfdc"))

    assert 1.0 < fmdc.growth_per_cycle < none.growth_per_cycle
    assert 1.04 < cfdc.growth_per_cycle < none.growth_per_cycle


def test_kalman_follows_a_stiffness_that_varies_and_least_squares_does_not():
    kalman = simulated("hexapod/time_varying_stiffness", "cfdc")
    rls = simulated("hexapod/time_varying_stiffness", "rls")

    assert kalman.rms_s_des < 0.03
    assert rls.rms_s_des > 0.08
    assert rls.rms_s_des > 3.0 * kalman.rms_s_des


def test_the_papers_gain_falls_short_in_the_drag_and_unit_gain_does_not():
    paper, unit = (simulated("hexapod/drag", variant) for variant in ("cfdc_dpdc", "unit_dc"))

    assert paper.rms_s_act > 0.05
    assert unit.rms_s_act < 0.01

"""`analyse`, `linearise` and `design-dpdc` on the project's FMUs, and a run that takes its design."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

from master.api import prepare_to_run
from master.cli import main
from master.docking.phase_lead import design
from master.errors import ConfigError
from master.experiment.prepare import Request
from master.system.config import PhaseLead
from tests.systems.analysed import CONFIGS, prepared

LOW = str(CONFIGS / "low_frequency.yaml")
HEXAPOD = str(CONFIGS / "hexapod" / "high_frequency.yaml")
UNIT_GAIN = ("--set", "compensator.gain_convention=unit_dc")


def command(*arguments):
    return CliRunner().invoke(main, [str(a) for a in arguments])


def answer(*arguments):
    found = command(*arguments, "--json")
    assert found.exit_code == 0, found.output
    return json.loads(found.stdout)


def test_analyse_gives_poles_margins_and_assumptions():
    found = answer("analyse", LOW, "--variant", "cfdc", "--zeros", "spacecraft.f:spacecraft.s_des")

    assert found["stable"]
    assert found["latency_budget"] == {"to": "spacecraft.f", "seconds": pytest.approx(1.563e-3, abs=2e-5)}
    assert [a["signal"] for a in found["assumptions"]] == ["compensator.identification_held"]
    assert {m["to"] for m in found["margins"]} >= {"spacecraft.f", "compensator.f_mea"}
    assert found["zeros"]
    assert found["notes"] == []


def test_analyse_reads_as_text():
    found = command("analyse", LOW)

    assert found.output.startswith("low_frequency\nstable")
    assert "latency budget" in found.output
    assert "assumed: compensator.identification_held = true" in found.output


def test_a_system_that_varies_with_time_is_analysed_along_its_run():
    varying = str(CONFIGS / "time_varying_stiffness.yaml")
    found = answer("analyse", varying, "--variant", "none")

    assert found["along_run"]["end"] == pytest.approx(1.231)  # where it runs away
    assert found["along_run"]["period"] == pytest.approx(1.0)
    assert found["dominant"]["zeta"] == pytest.approx(found["along_run"]["zeta"]["linear"], rel=1e-9)
    assert found["growth_rate"] == found["along_run"]["growth_rates"][-1] > 3.0
    assert not found["stable"]
    assert "varies with time" in found["notes"][0]


def test_a_sweep_draws_its_map(tmp_path):
    sweeps = ["--sweep", "spacecraft.f=0:0.004:5", "--sweep", "spacecraft.m_s=600:1000:3"]
    found = answer("analyse", LOW, "--variant", "cfdc", *sweeps, "--output", tmp_path)

    assert [x for x, _ in found["boundary"]] == [600.0, 800.0, 1000.0]
    assert all(1.4e-3 < delay < 1.7e-3 for _, delay in found["boundary"])
    assert (tmp_path / "stability.png").stat().st_size > 5000


@pytest.mark.parametrize(
    ("arguments", "fault"),
    [
        (["--zeros", "spacecraft.g:spacecraft.s_des"], "--zeros: no such connected input"),
        (["--zeros", "spacecraft.f"], "--zeros: not a pair"),
        (["--sweep", "spacecraft.f=0:5:3"], "--sweep: delay, got"),
        (["--sweep", "a=1", "--sweep", "b=1", "--sweep", "c=1"], "--sweep: too many, got 3"),
    ],
)
def test_wrong_questions_are_refused(arguments, fault):
    found = command("analyse", LOW, *arguments)

    assert found.exit_code == 2
    assert fault in found.output


def test_linearise_fits_the_linear_model_exactly_and_the_hexapod_within_its_form():
    linear, hexapod = answer("linearise", "motion_simulator_linear"), answer("linearise", "motion_simulator")

    assert linear["fit"]["K_p"] == pytest.approx(30.0, rel=1e-5)
    assert linear["fit"]["largest_phase_error_deg"] < 1e-3
    assert hexapod["fit"]["largest_magnitude_error"] < 0.006
    assert hexapod["fit"]["largest_phase_error_deg"] < 0.8
    assert hexapod["phase_deg"][1:5] == pytest.approx([-5.45, -10.94, -12.16, -30.70], abs=0.3)
    assert hexapod["magnitude"][4] == pytest.approx(0.912, abs=0.005)


def test_an_axis_that_a_model_has_not_is_refused():
    found = command("linearise", "motion_simulator_linear", "--axis", "yaw")

    assert found.exit_code == 2
    assert "--axis: motion_simulator_linear has none, got 'yaw'" in found.output


def test_design_covers_the_range_and_leaves_no_phase_at_its_upper_end():
    found = answer("design-dpdc", LOW, "--range", "m_s=700:1000")

    assert found["frequency"][0] == pytest.approx(0.874, abs=1e-3)
    assert found["left_deg"][-1] == pytest.approx(0.0, abs=0.02)
    assert max(map(abs, found["left_deg"])) < 2.5
    assert found["lag_deg"][-1] == pytest.approx(13.46, abs=0.05)
    assert found["dpdc_gain"] == 1.0
    assert found["magnitude"][-1] == pytest.approx(found["plant_magnitude"][-1], abs=2e-4)


def test_design_for_the_plants_amplitude_leaves_none_at_the_upper_end():
    """Below it the lead's own slope is left: |lead(f)| of Eq. 22 times the plant's amplitude."""
    paper, plant = (
        answer("design-dpdc", HEXAPOD, "--amplitude", amplitude, "--range", "k_p=320000:480000")
        for amplitude in ("paper", "plant")
    )
    f, T = np.array(plant["frequency"]), plant["T_lead"]
    lead = plant["K"] * np.abs((1 + 2j * np.pi * f * plant["alpha"] * T) / (1 + 2j * np.pi * f * T))

    assert plant["magnitude"][-1] == pytest.approx(1.0, abs=2e-4)
    assert plant["magnitude"] == pytest.approx(lead * plant["plant_magnitude"], abs=2e-4)
    assert plant["dpdc_gain"] == pytest.approx(1 / plant["plant_magnitude"][-1])
    assert plant["K"] == pytest.approx(paper["K"] * plant["dpdc_gain"])
    assert plant["left_deg"] == pytest.approx(paper["left_deg"], abs=1e-6)
    assert paper["magnitude"][-1] == pytest.approx(plant["plant_magnitude"][-1], abs=2e-4)


def test_design_reads_as_text():
    lines = command("design-dpdc", HEXAPOD, "--amplitude", "plant").output.splitlines()

    assert "dpdc_gain: 1.113" in lines[-4]
    assert lines[-2].split() == ["f", "[Hz]", *2 * ["lag", "[deg]", "amplitude"]]
    assert lines[-1].split()[-1] == "1.0000"


def test_two_rules_for_the_gain_are_refused():
    found = command("design-dpdc", HEXAPOD, *UNIT_GAIN)

    assert found.exit_code == 2
    assert "dpdc.amplitude: two rules for one gain, got plant and another" in found.output


def test_a_range_of_something_else_is_refused():
    found = command("design-dpdc", LOW, "--range", "mass=1:2")

    assert found.exit_code == 2
    assert "--range: no such attribute, got 'mass', expected one of m_s, m_e, k_m, k_p" in found.output


def test_a_run_takes_the_design_of_its_configuration():
    designed = answer("design-dpdc", HEXAPOD)
    compensator = prepared("hexapod/high_frequency", "cfdc_dpdc").system.instances["compensator"]

    assert compensator.value_of("dpdc_phase") == pytest.approx(designed["dpdc_phase"], rel=1e-4)
    assert compensator.value_of("dpdc_frequency") == pytest.approx(2.590, abs=1e-3)
    assert compensator.value_of("dpdc_gain") == pytest.approx(designed["dpdc_gain"], rel=1e-4)
    assert designed["amplitude"] == "plant"


def with_phase_lead(path, entry):
    lines = Path(HEXAPOD).read_text(encoding="utf-8").splitlines()
    path.write_text(
        "\n".join(f"dpdc: {entry}" if line.startswith("dpdc:") else line for line in lines), encoding="utf-8"
    )
    return path


def test_a_run_is_designed_for_the_largest_frequency_of_its_ranges(tmp_path):
    entry = "{design: auto, amplitude: plant, ranges: {k_p: [3.2e+5, 4.8e+5]}}"
    file = with_phase_lead(tmp_path / "system.yaml", entry)
    compensator = prepare_to_run(file, Request(variant="cfdc_dpdc")).system.instances["compensator"]
    designed = answer("design-dpdc", HEXAPOD, "--range", "k_p=320000:480000")

    for name in ("dpdc_phase", "dpdc_frequency", "dpdc_gain"):
        assert compensator.value_of(name) == pytest.approx(designed[name], rel=1e-4)
    assert compensator.value_of("dpdc_frequency") == pytest.approx(2.745, abs=1e-3)


@pytest.mark.parametrize(
    ("entry", "fault"),
    [
        (
            "{design: auto, ranges: {k_p: [.nan, 1]}}",
            "dpdc.ranges.k_p[0]: not a finite number, got .nan",
        ),
        ("{design: auto, ranges: {m_e: [2, 1]}}", "dpdc: no range of m_e, got (2.0, 1.0), expected positive"),
        ("{design: auto, fmu: contact}", "dpdc: no phase lead in contact, got no dpdc, dpdc_phase"),
        ("{design: auto, fmu: rig}", "dpdc.fmu: no such FMU, got 'rig', expected one of compensator, "),
    ],
)
def test_a_wrong_design_is_refused(tmp_path, entry, fault):
    found = command("run", with_phase_lead(tmp_path / "system.yaml", entry), "--output", tmp_path)

    assert found.exit_code == 2
    assert fault in found.output


def test_a_compensator_without_a_gain_of_its_own_gets_the_papers_design_only():
    experiment = prepared("low_frequency")
    instance = experiment.system.instances["compensator"]
    variables = tuple(v for v in instance.description.variables if v.name != "dpdc_gain")
    older = replace(instance, description=replace(instance.description, variables=variables))
    system = replace(experiment.system, instances=experiment.system.instances | {"compensator": older})
    experiment = replace(experiment, system=system)

    assert design(experiment, PhaseLead(design="auto")).gain_at_rest == pytest.approx(0.81, abs=0.01)
    with pytest.raises(ConfigError, match="no phase lead in compensator, got no dpdc_gain"):
        design(experiment, PhaseLead(design="auto", amplitude="plant"))


def test_a_gain_set_by_hand_stays():
    compensator = prepared("hexapod/high_frequency", "paper_gain").system.instances["compensator"]

    assert compensator.value_of("dpdc_gain") == 1.0
    assert compensator.value_of("dpdc_phase") == pytest.approx(0.549, abs=1e-3)


def test_what_is_set_by_hand_stays():
    compensator = prepared("hexapod/high_frequency", None, "compensator.dpdc_phase=0.5").system.instances[
        "compensator"
    ]

    assert compensator.value_of("dpdc_phase") == 0.5
    assert compensator.value_of("dpdc_frequency") == pytest.approx(2.590, abs=1e-3)

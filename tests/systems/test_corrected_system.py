"""What `diagnose` hands over: FMUs of both flavours, and a system that runs with them wherever it is put."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import numpy as np
import pytest
import yaml
from click.testing import CliRunner
from fmpy import read_model_description
from fmpy.validation import validate_fmu

from master.cli import main
from master.diagnosis.answer.answer import answer
from tests.rig import Effects, record

pytestmark = pytest.mark.long

CASE = Path(__file__).parents[2] / "configs" / "measured" / "docking_rig.yaml"
SLOTS = {
    "contact.guide_force": ["coulomb", "quadratic_damping"],
    "contact.rope_force": ["cubic_stiffness"],
    **{s: ["offset"] for s in ("force_sensor.output", "motion_simulator.s_cmd", "spacecraft.f")},
    **{f"compensator.{s}": ["offset"] for s in ("force_correction", "command")},
}
COULOMB = 4.0


@pytest.fixture(scope="module")
def case_file(tmp_path_factory):
    """A case with friction in the guide."""
    folder = tmp_path_factory.mktemp("case")
    record(Effects(coulomb=COULOMB), seed=2).write(folder / "rig.npz")
    case = yaml.safe_load(CASE.read_text()) | {"slots": SLOTS, "recordings": {"rich": "rig.npz"}}
    case["system"] = str((CASE.parent / case["system"]).resolve())
    (folder / "case.yaml").write_text(yaml.safe_dump(case))
    return folder / "case.yaml"


@pytest.fixture(scope="module")
def handed_over(case_file, tmp_path_factory):
    """The results of the case, moved to another folder."""
    folder = case_file.parent
    report = answer(case_file, folder / "out", lambda _: None)
    moved = tmp_path_factory.mktemp("elsewhere") / "results"
    shutil.move(folder / "out", moved)
    return report, moved


def run(system, flavour, folder):
    arguments = ["run", str(system), "--flavour", flavour, "--stop-time", "5", "--output", str(folder)]
    result = CliRunner().invoke(main, arguments)
    assert result.exit_code == 0, result.output
    return np.genfromtxt(folder / "result.csv", delimiter=",", names=True)


def test_friction_becomes_part_of_the_contact(handed_over):
    report, folder = handed_over
    system = yaml.safe_load((folder / "docking_rig_corrected.yaml").read_text())

    assert [(e["fmu"], e["effect"]) for e in report["effects"]] == [("contact", "coulomb")]
    assert report["effects"][0]["status"] == "traced"
    assert system["fmus"]["contact"]["source"] == "./native/docking_contact__guide_force_coulomb.fmu"
    level = system["fmus"]["contact"]["parameters"]["guide_force_coulomb_level"]
    assert level == pytest.approx(COULOMB, rel=0.02)
    assert all((folder / name).is_file() for name in report["files"])


@pytest.mark.parametrize("flavour", ["native", "python"])
def test_corrected_fmu_is_valid(handed_over, flavour):
    (fmu,) = (handed_over[1] / flavour).glob("*.fmu")

    assert validate_fmu(str(fmu)) == []
    description = read_model_description(str(fmu))
    assert description.modelName == "docking_contact__guide_force_coulomb"
    starts = {v.name: v.start for v in description.modelVariables}
    level = handed_over[0]["effects"][0]["parameters"]["level"]
    assert float(starts["guide_force_coulomb_level"]) == level


def test_a_replay_of_the_corrected_system_has_the_reported_error_to_the_last_digit(handed_over, case_file):
    folder = handed_over[1]
    report = json.loads((folder / "report.json").read_text())
    result = CliRunner().invoke(main, ["replay", str(case_file), "--with", str(folder), "--json"])

    assert result.exit_code == 0, result.output
    errors = json.loads(result.stdout)["errors"]
    signal = "force_sensor.f_mea"
    assert errors[signal] == report["after"][signal]


def test_a_replay_of_the_case_itself_has_the_error_of_the_nominal_model(handed_over, case_file):
    result = CliRunner().invoke(main, ["replay", str(case_file), "--json"])

    report = json.loads((handed_over[1] / "report.json").read_text())
    assert json.loads(result.stdout)["errors"] == report["nominal"]


def test_the_whole_loop_runs_alike_in_both_flavours(handed_over, tmp_path):
    system = handed_over[1] / "docking_rig_corrected.yaml"
    other = system.with_name("python.yaml")
    other.write_text(system.read_text().replace("./native/", "./python/"))
    native = run(system, "native", tmp_path / "native")
    python = run(other, "python", tmp_path / "python")

    assert len(native) == 5001
    assert native.dtype.names == python.dtype.names
    for name in native.dtype.names:
        assert np.abs(native[name] - python[name]).max() <= 1e-12, name

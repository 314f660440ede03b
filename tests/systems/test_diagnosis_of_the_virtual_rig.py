"""Recordings of the virtual rig with a known truth; the numbers of many trials stand in docs/diagnosis.md."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import yaml
from fmpy import read_model_description
from fmpy.validation import validate_fmu

from master.api import prepare_to_run
from master.diagnosis.answer.answer import answer
from master.diagnosis.case.case import load_case
from master.diagnosis.judge.diagnose import diagnose
from master.errors import ConfigError
from master.experiment.prepare import Request
from master.stepping.simulate import simulate
from tests.rig import Effects, record

pytestmark = pytest.mark.long

CASE = Path(__file__).parents[2] / "configs" / "measured" / "docking_rig.yaml"


def report_of(effects, folder, seed=1):
    record(effects, seed=seed).write(folder / "rig.npz")
    case = yaml.safe_load(CASE.read_text())
    case["system"] = str((CASE.parent / case["system"]).resolve())
    case["recordings"] = {"rich": {"file": "rig.npz"}}
    (folder / "case.yaml").write_text(yaml.safe_dump(case))
    report = answer(folder / "case.yaml", folder / "out", lambda _: None)
    assert report["explained_share"] <= report["ceiling"]["share"] + 0.05
    return report


@pytest.fixture(scope="module")
def coulomb(tmp_path_factory):
    folder = tmp_path_factory.mktemp("coulomb")
    return report_of(Effects(coulomb=4.0), folder), folder / "out"


def test_friction_of_the_guide_is_traced(coulomb):
    report, _ = coulomb

    assert report["verdict"] == "traced"
    assert report["subsystem"] == "contact"
    assert [(e["slot"], e["effect"]) for e in report["effects"]] == [("guide_force", "coulomb")]
    assert report["effects"][0]["parameters"]["level"] == pytest.approx(4.0, rel=0.02)
    assert report["after"]["force_sensor.f_mea"]["rmse"] < 0.55
    assert report["explained_share"] > 0.95


def test_wrong_prefix_and_wrong_sign_are_told_at_once(tmp_path):
    """Force in kN that the case takes for N, velocity with the other sign."""
    recording = record(seed=1)
    recording.columns["f_mea"] = 1e-3 * recording["f_mea"]
    recording.write(tmp_path / "rig.npz")
    case = yaml.safe_load(CASE.read_text())
    case["system"] = str((CASE.parent / case["system"]).resolve())
    case["recordings"] = {"rich": {"file": "rig.npz"}}
    case["signals"]["v_wrong"] = {"column": "v_act", "unit": "m/s", "sign": -1}
    case["compared"]["motion_simulator.v_act"] = "v_wrong"
    (tmp_path / "case.yaml").write_text(yaml.safe_dump(case))

    with pytest.raises(ConfigError) as error:
        diagnose(load_case(tmp_path / "case.yaml"), lambda _: None)

    force, velocity = sorted(p for p in error.value.problems if "compensator" not in p)
    assert "force_sensor.f_mea: moves like the model at another size, got 0.001 times" in force
    assert "with 'f_mea' in 'N', expected about 1" in force
    assert "motion_simulator.v_act: moves like the model at another size, got -1 times" in velocity


def test_corrected_models_are_valid_and_agree_in_both_flavours(coulomb):
    _, folder = coulomb
    rows = {}
    for flavour in ("native", "python"):
        system = folder / f"{flavour}.yaml"
        text = (folder / "docking_rig_corrected.yaml").read_text()
        system.write_text(text.replace("./native/", f"./{flavour}/"))
        [fmu] = (folder / flavour).glob("*.fmu")
        assert validate_fmu(str(fmu)) == []
        assert read_model_description(str(fmu)).modelName == "docking_contact__guide_force_coulomb"
        experiment = prepare_to_run(system, Request(flavour=flavour, stop_time=2.0))
        outcome = simulate(experiment.system, experiment.schedule, experiment.grid)
        rows[flavour] = np.asarray(outcome.result.values)

    assert rows["native"].shape[0] == 2001
    assert np.abs(rows["native"] - rows["python"]).max() <= 1e-12


def test_nothing_is_found_where_nothing_is_missing(tmp_path):
    report = report_of(Effects(), tmp_path)

    assert report["verdict"] in ("nothing missing", "parameters only")
    assert report["effects"] == []


@pytest.mark.parametrize(
    ("effects", "subsystem"),
    [
        (Effects(quantisation=2.0), "force_sensor"),
        (Effects(simulator_delay=2.0), "motion_simulator"),
        (Effects(spacecraft_offset=5.0), "spacecraft"),
        (Effects(command_quantisation=2e-4), "compensator"),
    ],
)
def test_effect_is_found_in_its_subsystem(effects, subsystem, tmp_path):
    assert report_of(effects, tmp_path)["subsystem"] == subsystem


@pytest.mark.parametrize("effects", [Effects(position_friction=3.0), Effects(varying_delay=4e-3)])
def test_law_of_no_listed_kind_is_undeclared_and_yet_added(effects, tmp_path):
    report = report_of(effects, tmp_path)

    assert report["verdict"] == "undeclared"
    assert all(e["effect"].startswith("learned_") for e in report["effects"])
    before, after = (report[which]["force_sensor.f_mea"]["rmse"] for which in ("before", "after"))
    assert after < 0.3 * before  # noise of 0.5 N is left of 4 N

"""The measured cases from the command's view: what is found, and the error on the sealed part."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
import yaml
from click.testing import CliRunner

from master.cli.diagnose import diagnose

CASES = Path(__file__).parents[2] / "configs" / "measured"


def report_of(case, folder):
    result = CliRunner().invoke(diagnose, [str(case), "--output", str(folder), "--json"])
    assert result.exit_code == 0, result.output
    return json.loads(result.stdout)


def only(effects, name, folder):
    """The case with other slots, in a folder of its own."""
    case = yaml.safe_load((CASES / f"{name}.yaml").read_text())
    path = folder / f"{name}.yaml"
    path.write_text(yaml.safe_dump(case | {"slots": effects}))
    return path


@pytest.fixture(scope="module")
def emps(data, tmp_path_factory):
    folder = tmp_path_factory.mktemp("emps")
    return report_of(CASES / "emps.yaml", folder), folder


def test_axis_lacks_asymmetric_friction(emps):
    report, _ = emps

    assert report["verdict"] == "traced"
    assert [e["effect"] for e in report["effects"]] == ["asymmetric_friction"]
    assert 17.0 < report["before"]["axis.force"]["nrmse_percent"] < 18.5
    assert report["after"]["axis.force"]["nrmse_percent"] <= 5.4


def test_report_stands_alone(emps):
    report, folder = emps
    page = (folder / "report.html").read_text()

    assert "data:image/png;base64," in page
    assert "http" not in page
    assert all((folder / name).is_file() for name in report["files"])


def test_coulomb_and_offset_have_the_parameters_of_the_authors(data, tmp_path):
    path = only({"axis.friction": ["coulomb", "offset", "quadratic_damping"]}, "emps", tmp_path)
    report = report_of(path, tmp_path / "out")

    effects = {e["effect"]: e["parameters"] for e in report["effects"]}
    parameters = {k: v["with_effect"] for k, v in report["parameters"].items()}
    assert report["after"]["axis.force"]["nrmse_percent"] <= 6.0
    assert effects["coulomb"]["level"] == pytest.approx(20.394, rel=0.01)
    assert effects["offset"]["offset"] == pytest.approx(-3.165, rel=0.01)
    assert parameters["axis.mass"] == pytest.approx(95.109, rel=0.01)
    assert parameters["axis.damping"] == pytest.approx(203.50, rel=0.01)


def test_oscillator_lacks_hardening(data, tmp_path):
    report = report_of(CASES / "silverbox.yaml", tmp_path)

    assert report["verdict"] == "traced"
    assert [e["effect"] for e in report["effects"]] == ["cubic_stiffness"]
    assert 1e3 * report["before"]["box.y"]["rmse"] == pytest.approx(14.3, abs=0.3)
    assert 1e3 * report["after"]["box.y"]["rmse"] <= 0.50


def test_friction_device_sticks_before_it_slides(data, tmp_path):
    report = report_of(CASES / "brfd.yaml", tmp_path)

    names = [e["effect"] for e in report["effects"]]
    rivals = {n.rpartition(": ")[2] for f in report["undistinguished"] for n in f["family"]}
    assert names[0] == "presliding"
    assert "clearance" in {*names, *rivals}
    assert report["before"]["device.force"]["rmse"] > 9e3
    assert report["after"]["device.force"]["rmse"] <= 1.8e3

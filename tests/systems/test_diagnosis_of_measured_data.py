"""The measured cases from the command's view: what is found, and the error on the sealed part."""

from __future__ import annotations

import json
from pathlib import Path

import jsonschema
import pytest
import yaml
from click.testing import CliRunner

from master.cli.diagnose import diagnose
from master.diagnosis.answer.report.schema import report_schema
from tests.systems.page_checks import faults

pytestmark = pytest.mark.long

KEYS = {"verdict", "effects", "subsystem", "before", "after", "explained_share", "ceiling"} | {
    "runners_up",
    "undistinguished",
    "files",
}
CASES = Path(__file__).parents[2] / "configs" / "measured"


def report_of(case, folder):
    result = CliRunner().invoke(diagnose, [str(case), "--output", str(folder), "--json"])
    assert result.exit_code == 0, result.output
    report = json.loads(result.stdout)
    assert report["explained_share"] <= report["ceiling"]["share"] + 0.05
    return report


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

    assert report["verdict"] == "partly, with a remainder"  # the force is known far better than modelled
    assert [e["effect"] for e in report["effects"]] == ["asymmetric_friction"]
    assert 17.0 < report["before"]["axis.force"]["nrmse_percent"] < 18.5
    assert report["after"]["axis.force"]["nrmse_percent"] <= 5.4


def test_report_has_the_keys_that_are_promised(emps):
    report, folder = emps
    error = {"rmse", "nrmse_percent", "max", "energy", "rmse_interval"}

    assert set(report) >= KEYS
    assert all(set(report[which]["axis.force"]) == error for which in ("before", "after", "nominal"))
    low, high = report["after"]["axis.force"]["rmse_interval"]
    assert low < report["after"]["axis.force"]["rmse"] < high < report["before"]["axis.force"]["rmse"]
    assert report["ceiling"]["share"] > 0.9
    assert all(set(r) == {"round", "effect", "gain", "why", "sealed_rmse"} for r in report["runners_up"])
    assert json.loads((folder / "report.json").read_text()) == report
    jsonschema.Draft202012Validator(report_schema()).validate(report)
    assert all((folder / name).is_file() for name in report["files"])


def test_every_parameter_has_its_uncertainty(emps):
    parameters = emps[0]["parameters"]

    assert {"axis.mass", "axis.damping", "axis.friction_asymmetric_friction_forward"} <= set(parameters)
    assert all(0.0 < p["deviation"] < abs(p["with_effect"]) for p in parameters.values())


@pytest.fixture(scope="module")
def browser(browser, emps):
    browser.show(emps[1] / "report.html")
    return browser


def test_page_shows_the_verdict_first_and_all_panels_without_an_error(emps, browser):
    report, _ = emps
    images = browser.run("return [...document.images].map(i => i.complete && i.naturalWidth >= 600)")
    fetched = browser.run("return performance.getEntriesByType('resource').map(e => e.name.slice(0, 5))")
    sizes = browser.run(
        "return [...document.querySelectorAll('p, td, th, li, figcaption')]"
        ".map(e => parseFloat(getComputedStyle(e).fontSize))"
    )

    texts = browser.run("return [...document.querySelectorAll('p')].slice(0, 2).map(p => p.textContent)")
    assert texts[0].startswith(("The model lacks ", "No law is sure; "))
    assert "times the noise floor" in texts[0]
    assert texts[1] == report["sentence"]
    assert all(images)
    assert len(images) >= sum(f.endswith(".png") for f in report["files"])
    assert set(fetched) <= {"data:"}
    assert min(sizes) >= 13.0
    assert browser.run("return document.documentElement.scrollWidth") == 1280
    assert faults(browser, emps[1] / "report.html") == []


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

    assert report["verdict"] == "partly, with a remainder"  # 0.5 mV is more than noise
    assert report["effects"][0]["effect"] == "cubic_stiffness"
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


def test_damper_has_friction_with_memory_and_an_offset(data, tmp_path):
    """Independent fits on the sealed records: viscous 147 N, with an offset and Dahl's friction 26.4 N."""
    laws = ["asymmetric_friction", "coulomb", "offset", "presliding", "dahl", "structural_damping"]
    report = report_of(only({"damper.force": laws}, "mr_damper", tmp_path), tmp_path / "out")

    assert report["before"]["damper.force"]["rmse"] == pytest.approx(147.0, abs=2.0)
    assert report["after"]["damper.force"]["rmse"] <= 20.0
    assert report["effects"][0]["effect"] == "presliding"
    assert report["effects"][1]["effect"] == "asymmetric_friction"  # Coulomb and an offset, and more
    assert report["verdict"] == "partly, with a remainder"


def test_tanks_lack_what_flattens_the_lower_outflow(data, tmp_path):
    """Independent fits on the sealed record: linear 1.11 V, outflows by the square root 0.63 V."""
    slots = {"tanks.upper_outflow": ["overflow"], "tanks.lower_outflow": ["offset", "power_law", "drift"]}
    report = report_of(only(slots, "tanks", tmp_path), tmp_path / "out")

    assert report["before"]["tanks.h_2"]["rmse"] == pytest.approx(1.11, abs=0.03)
    assert report["after"]["tanks.h_2"]["rmse"] <= 0.66
    [offset] = report["effects"]  # flattens a line; its size trades against the rates of the outflows
    assert (offset["slot"], offset["effect"], offset["status"]) == ("lower_outflow", "offset", "nearest name")
    assert "known to differ from zero" in offset["why"]
    assert report["verdict"] == "undeclared"


def test_tanks_have_roots_and_overflow_in_both_outflows(data, tmp_path):
    """Independent fits on the sealed record: outflows by the square root 0.63 V, with overflow 0.29 V."""
    laws = ["offset", "power_law", "overflow"]
    slots = {"tanks.upper_outflow": laws, "tanks.lower_outflow": laws}
    report = report_of(only(slots, "tanks", tmp_path), tmp_path / "out")

    assert report["after"]["tanks.h_2"]["rmse"] <= 0.40
    assert report["verdict"] == "partly, with a remainder"
    assert {e["effect"] for e in report["effects"]} == {"power_law", "overflow"}
    assert {e["slot"] for e in report["effects"]} == {"upper_outflow", "lower_outflow"}

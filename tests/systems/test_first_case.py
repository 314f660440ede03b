"""The small shipped case: a servo axis in closed form whose friction is a sharp sign."""

from __future__ import annotations

import json
from pathlib import Path

import jsonschema
import pytest

from master.diagnosis.answer.answer import answer
from master.diagnosis.answer.report.schema import report_schema
from tests.rig.first_case import DAMPING, FRICTION, MASS, NOISE

CASE = Path(__file__).parents[2] / "configs" / "measured" / "first_case.yaml"


def test_sharp_friction_is_traced_to_the_noise(tmp_path):
    """The sign changes within a row; a search that kept it rounded would leave twice the noise."""
    report = answer(CASE, tmp_path / "out", lambda _: None)

    written = json.loads((tmp_path / "out" / "report.json").read_text(encoding="utf-8"))
    jsonschema.Draft202012Validator(report_schema()).validate(written)
    assert (report["verdict"], report["subsystem"]) == ("traced", "axis")
    assert [(e["slot"], e["effect"]) for e in report["effects"]] == [("friction", "coulomb")]
    found = {k.removeprefix("axis."): p for k, p in report["parameters"].items()}
    for name, truth in (("mass", MASS), ("damping", DAMPING), ("friction_coulomb_level", FRICTION)):
        assert found[name]["with_effect"] == pytest.approx(truth, abs=3.5 * found[name]["deviation"])
    assert report["after"]["axis.force"]["rmse"] < 1.05 * NOISE

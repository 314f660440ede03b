"""A new identifier is one file: nothing else is edited, and the FMU has it."""

from __future__ import annotations

import json
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

import fmu_sources
from fmu_sources.compensator.identifiers.framework.catalogue import listed
from fmu_sources.compensator.identifiers.framework.identifier import Identifier

PACKAGE = Path(fmu_sources.__file__).parent
FOLDER = PACKAGE / "compensator" / "identifiers"

LMS = '''
"""Least mean squares: Y = Y + mu (Z - H Y) H."""

from ...framework.variables import parameter, sampled, state
from .framework.identifier import Estimate, Identifier


def estimate(measurement, x, p, m):
    error = measurement.Z - sum(h * y for h, y in zip(measurement.H, measurement.Y))
    Y = tuple(y + p.lms_rate * error * h for h, y in zip(measurement.H, measurement.Y))
    return Estimate(Y, {"n_periods": x.n_periods + 1.0})


IDENTIFIER = Identifier(
    name="lms",
    number=4,
    held_by="identification_held",
    estimate=estimate,
    parameters=(parameter("lms_rate", 0.5, "1", "Rate mu", above=0.0),),
    states=(sampled(state("n_periods", "1", "Periods seen"), hidden=True),),
)
'''

RUN = """
import json
from fmu_sources.composed.registry import load, modules
from fmu_sources.export.native import generate
from fmu_sources.export.python_flavour import python_sources
from fmu_sources.framework.instance import Instance

model = load("compensator")
rows = []
for identifier in (4, 3):
    c = Instance(model)
    for name, value in dict(identifier=identifier, preset=1, fmdc=False, cfdc=False, dpdc=False).items():
        c[name] = value
    c.initialise()
    rows.append([c[n] for n in "abcde"])
    for k, held in enumerate((False, False, True)):
        c["f_mea"], c["s_act"], c["identification_held"] = 2.0 + k, 0.01 * (k + 1), held
        c.step(k * 1e-3, 1e-3)
        rows.append([c[n] for n in "abcde"] + [c["n_periods"]])
(item,) = [v for v in model.variables if v.name == "identifier"]
print(json.dumps({
    "items": [i.name for i in item.items],
    "rows": rows,
    "carried": sorted(python_sources(*modules("compensator"))),
    "c": b"lms_rate" in generate(model, "")["model_variables.c"],
}))
"""


@pytest.fixture(scope="module")
def with_lms(tmp_path_factory):
    folder = tmp_path_factory.mktemp("sources")
    shutil.copytree(PACKAGE, folder / "fmu_sources", ignore=shutil.ignore_patterns("__pycache__"))
    (folder / "fmu_sources/compensator/identifiers/lms.py").write_text(LMS, encoding="utf-8")
    done = subprocess.run(
        [sys.executable, "-c", RUN], cwd=folder, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


def test_one_file_brings_an_item_its_parameter_and_its_code(with_lms):
    assert with_lms["items"] == ["kalman", "rls", "fixed", "lms"]
    assert "compensator/identifiers/lms.py" in with_lms["carried"]
    assert with_lms["c"]


def test_it_estimates_by_its_own_law_until_it_is_held(with_lms):
    start, first, second, held = with_lms["rows"][:4]
    H = (0.0, 0.0, -0.01, -0.0, -0.0)  # forces and positions before the start are zero
    error = 2.0 - sum(h * y for h, y in zip(H, start, strict=True))

    assert first[:5] == pytest.approx([y + 0.5 * error * h for h, y in zip(H, start, strict=True)], rel=1e-12)
    assert first[5] == 1.0
    assert second[5] == 2.0
    assert held == second


def test_its_states_keep_still_while_another_identifier_is_chosen(with_lms):
    start, *others = with_lms["rows"][4:]

    assert others == [[*start, 0.0]] * 3


def test_a_law_that_is_not_one_is_refused():
    with pytest.raises(ValueError, match="both: one of settings and estimate is needed"):
        Identifier(name="both", number=9, held_by=None)


def test_the_table_of_identifiers_names_each_once():
    rows = re.findall(r"^\| `(\w+)\.py` \| .* \| (.*) \|$", (FOLDER / "README.md").read_text(), re.MULTILINE)

    held = {one.name: f"`{one.held_by}`" if one.held_by else "does not learn" for one in listed()}
    assert rows == list(held.items())

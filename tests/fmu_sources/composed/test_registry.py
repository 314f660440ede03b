"""A subsystem is a folder: nothing but the folder says that it is there and whether it is released."""

from __future__ import annotations

import ast
import json
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

import fmu_sources
from fmu_sources.composed.registry import load, model_files, modules, source_files
from fmu_sources.export.reference_data import agreement
from fmu_sources.export.release import release_models

PACKAGE = Path(fmu_sources.__file__).parent

MODEL = '''
"""{name}: y = gain u."""

from ..framework.model import Model, no_effect
from .plugs import VARIABLES


class Gain(Model):
    """See the module's text."""

    name = "{name}"
    description = "A gain"
    variables = VARIABLES

    def outputs(self, t, x, u, p, m, slot=no_effect):
        return {{"y": {gain} * u.u}}


MODEL = Gain()
'''

PLUGS = '''
"""The plugs that all gains share."""

from ..framework.variables import declare, input_, output

VARIABLES = declare(input_("u", "1", "Input"), output("y", "1", "Output"))
'''

ASK = """
import json
from fmu_sources.composed.registry import load, model_files, modules
from fmu_sources.export.native import generate
from fmu_sources.export.python_flavour import python_sources
from fmu_sources.export.release import release_models
from fmu_sources.framework.instance import Instance

instance = Instance(load("tripled__u_offset"))
instance["u"] = 2.0
instance.initialise()
print(json.dumps({
    "models": list(model_files()),
    "released": release_models(),
    "value": instance["y"],
    "carried": sorted(n for n in python_sources(*modules("doubled")) if n.startswith("gains")),
    "native": b"2.0 *" in generate(load("doubled"), "")["model_equations.c"],
}))
"""


def asked(folder, question=ASK):
    return subprocess.run(
        [sys.executable, "-c", question], cwd=folder, capture_output=True, text=True, check=False
    )


@pytest.fixture
def copied(tmp_path):
    """A copy of the package with a folder of two models that share a module."""
    copy = tmp_path / "fmu_sources"
    shutil.copytree(PACKAGE, copy, ignore=shutil.ignore_patterns("__pycache__"))
    (copy / "gains").mkdir()
    (copy / "gains/__init__.py").write_text('"""Gains."""\n\nRELEASED = True\n')
    (copy / "gains/plugs.py").write_text(PLUGS)
    for name, gain in (("doubled", 2.0), ("tripled", 3.0)):
        (copy / f"gains/{name}.py").write_text(MODEL.format(name=name, gain=gain))
    return tmp_path


def test_a_folder_of_models_that_declares_itself_is_found_and_released(copied):
    done = asked(copied)
    assert done.returncode == 0, done.stderr
    found = json.loads(done.stdout)

    assert set(found["models"]) - set(model_files()) == {"doubled", "tripled"}
    assert set(found["released"]) - set(release_models()) == {"doubled", "tripled"}
    assert found["value"] == 6.0
    assert found["carried"] == ["gains/__init__.py", "gains/doubled.py", "gains/plugs.py"]
    assert found["native"]


def test_a_folder_that_is_not_for_the_release_is_not_in_it(copied):
    (copied / "fmu_sources/gains/__init__.py").write_text('"""Gains."""\n\nRELEASED = False\n')
    found = json.loads(asked(copied).stdout)

    assert {"doubled", "tripled"} <= set(found["models"])
    assert found["released"] == release_models()


def test_two_models_of_one_name_are_refused(copied):
    shutil.copy(copied / "fmu_sources/gains/doubled.py", copied / "fmu_sources/rigs/doubled.py")
    done = asked(copied)

    assert done.returncode == 1
    assert "model name is taken, got 'doubled', also in" in done.stderr


def test_every_file_with_a_model_is_in_a_folder_of_models():
    holding = {
        path
        for path in PACKAGE.rglob("*.py")
        for node in ast.parse(path.read_text(encoding="utf-8")).body
        if isinstance(node, ast.Assign) and ast.unparse(node.targets[0]) == "MODEL"
    }

    assert holding == set(model_files().values())


def test_the_release_holds_the_subsystems_and_no_rig_and_no_method_yet():
    assert release_models() == [
        "compensator",
        "docking_contact",
        "force_sensor",
        "motion_simulator",
        "motion_simulator_linear",
        "real_docking",
        "spacecraft",
    ]
    assert {p.parent.name for n, p in model_files().items() if n not in release_models()} == {
        "rigs",
        "compensators",
        "guard",
    }


def test_files_of_a_composed_model_are_its_base_and_its_laws():
    names = {p.relative_to(PACKAGE).as_posix() for p in modules("docking_contact__rope_force_slack")}

    assert {"docking_contact/docking_contact.py", "effects/slack.py"} <= names
    assert PACKAGE / "effects/framework/effect.py" in source_files(
        *modules("docking_contact__rope_force_slack")
    )


@pytest.mark.parametrize(
    ("name", "bound"), [("spacecraft", 1e-12), ("docking_contact", 1e-8), ("motion_simulator", 5e-5)]
)
def test_agreement_is_that_of_rounding_of_integration_or_declared(name, bound):
    assert agreement(load(name)) == bound

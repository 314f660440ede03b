"""`dockloop new-model` writes a model that builds, and a test that passes."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest
from click.testing import CliRunner

from fmu_sources.export.own_model import load_model
from fmu_sources.framework.instance import Instance
from master.cli import main

PROJECT = Path(__file__).parents[3]


def written(*arguments):
    return CliRunner().invoke(main, ["new-model", *map(str, arguments)])


def test_the_model_loads_by_its_path_and_has_the_name(tmp_path):
    done = written("heavy_sledge", "--output", tmp_path)
    model = load_model(tmp_path / "heavy_sledge.py")

    assert done.exit_code == 0, done.output
    assert (model.name, model.description, type(model).__name__) == (
        "heavy_sledge",
        "Heavy sledge.",
        "HeavySledge",
    )
    assert [slot.name for slot in model.slots] == ["friction"]
    assert Instance(model)["mass"] == 10.0


def test_its_test_passes_and_fails_with_another_equation(tmp_path):
    written("sledge", "--output", tmp_path)
    command = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", "--rootdir", str(tmp_path)]
    environment = {"PYTHONPATH": f"{PROJECT}:{tmp_path}", "PATH": "/usr/bin:/bin"}

    def status():
        test = str(tmp_path / "test_sledge.py")
        return subprocess.run([*command, test], cwd=tmp_path, env=environment, check=False).returncode

    assert status() == 0
    file = tmp_path / "sledge.py"
    file.write_text(file.read_text().replace("(u.f - friction) / p.mass", "u.f / p.mass"))
    assert status() == 1


@pytest.mark.parametrize("name", ["two words", "class", "1st", "a__b", "../x", "\u03b1"])
def test_a_name_that_python_or_a_composition_does_not_take_is_refused(name, tmp_path):
    done = written(name, "--output", tmp_path)

    assert (done.exit_code, list(tmp_path.iterdir())) == (2, [])
    assert "NAME" in done.output


def test_no_file_is_replaced(tmp_path):
    (tmp_path / "test_sledge.py").write_text("mine")
    done = written("sledge", "--output", tmp_path)

    assert done.exit_code == 2
    assert [f.name for f in tmp_path.iterdir()] == ["test_sledge.py"]

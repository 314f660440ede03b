"""The oldest versions that `pyproject.toml` allows of what a run uses: commands, a sample of the tests."""

from __future__ import annotations

import json
import subprocess
from pathlib import Path

import pytest
from packaging.requirements import Requirement

from tests.installed.conftest import PROJECT, Stranger, oldest_versions

pytestmark = pytest.mark.long

CAMPAIGN = """\
name: few
description: A few runs
system: low_frequency
vary:
  force_sensor.T_f: {uniform: [8, 12], unit: ms}
design: {method: sobol, size: 4, seed: 1}
"""
SAMPLE = (
    "tests/dockloop/test_simulation.py",
    "tests/master/campaign/test_answers.py",
    "tests/master/recording",
    "tests/master/diagnosis/numerics",
    "tests/master/system/test_config.py",
)


def test_the_environment_has_them(installed_python: Path) -> None:
    listed = [str(installed_python), "-m", "pip", "list", "--format=json"]
    done = subprocess.run(listed, check=True, capture_output=True, text=True)
    found = {one["name"].lower(): one["version"] for one in json.loads(done.stdout)}
    bounds = [Requirement(line) for line in oldest_versions()]

    assert len(bounds) > 10
    assert [str(b) for b in bounds if found[b.name.lower()] not in b.specifier] == []


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (
            ("run", "low_frequency", "--stop-time", "0.2", "--isolate", "all", "--page"),
            "completed at t = 0.2 s after 200 steps",
        ),
        (("analyse", "low_frequency"), "stable: the largest growth of a pole is -0.0297"),
        (("sweep", "few.yaml", "--workers", "1"), "4 of 4 runs: 4 completed"),
    ],
    ids=["run", "analyse", "sweep"],
)
def test_a_command_works_with_them(stranger: Stranger, arguments: tuple[str, ...], words: str) -> None:
    """Rows are compared, and a case is diagnosed, in `test_wheel.py`."""
    (stranger.folder / "work" / "few.yaml").write_text(CAMPAIGN, encoding="utf-8")

    assert words in stranger.dockloop(*arguments, "--output", arguments[0]).stdout


def test_a_sample_of_the_tests_passes_with_them(installed_python: Path) -> None:
    command = [str(installed_python), "-m", "pytest", "-q", "-p", "no:cacheprovider", *SAMPLE]
    done = subprocess.run(command, cwd=PROJECT, check=False, capture_output=True, text=True)

    assert done.returncode == 0, done.stdout[-6000:] + done.stderr[-2000:]

"""Every program of docs/python.md runs as it is."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import pytest

from tests.costs import long_for

PROJECT = Path(__file__).parents[2]
SECTIONS = re.split(r"^## ", (PROJECT / "docs" / "python.md").read_text(encoding="utf-8"), flags=re.MULTILINE)
PROGRAMS = {
    section.partition("\n")[0]: re.findall(r"```python\n(.*?)```", section, re.DOTALL)
    for section in SECTIONS[1:]
}
NEEDS = {"A campaign": ("pandas", "xarray"), "Run and plot": ("pandas", "xarray"), "Diagnose": ("casadi",)}


@pytest.mark.slow
@pytest.mark.parametrize("heading", long_for(["Diagnose"], PROGRAMS))
def test_the_program_runs(heading, tmp_path):
    for module in NEEDS.get(heading, ()):
        pytest.importorskip(module)
    [program] = PROGRAMS[heading]
    command = [sys.executable, "-c", program]
    done = subprocess.run(
        command, cwd=tmp_path, capture_output=True, text=True, env=environment(), check=False
    )

    assert done.returncode == 0, done.stderr
    assert done.stderr == ""


def environment():
    import os

    return os.environ | {"PYTHONPATH": str(PROJECT)}


def test_the_guide_has_the_four_programs_that_a_user_writes_first():
    assert list(PROGRAMS)[:4] == [
        "Run and plot",
        "Sweep in a loop",
        "Step by step, with a block in Python",
        "Diagnose",
    ]

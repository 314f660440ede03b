"""The guide to other tools: its table is that of the declarations, its programs run."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import pytest

from tests.interop.experiment_in_fmu import Vectors
from tests.interop.variable_table import GUIDE, with_table

TRIED = {"FMPy": "fmpy", "ecospy": "peers", "libcosimpy": "peers"}


def program(heading: str) -> str:
    """Give the Python program under a heading."""
    section = re.split(r"^### ", GUIDE.read_text(encoding="utf-8"), flags=re.MULTILINE)
    (text,) = (part for part in section if part.startswith(f"{heading}\n"))
    return re.search(r"```python\n(.*?)```", text, re.DOTALL)[1]


def test_the_variable_table_is_that_of_the_declarations() -> None:
    guide = GUIDE.read_text(encoding="utf-8")

    assert guide == with_table(guide), "run: python tests/interop/variable_table.py"


@pytest.mark.slow
@pytest.mark.parametrize("heading", TRIED)
def test_the_program_of_the_guide_runs(
    heading: str, compensators: dict[str, Vectors], request: pytest.FixtureRequest, tmp_path: Path
) -> None:
    python = sys.executable if TRIED[heading] == "fmpy" else request.getfixturevalue("peer_python")
    (tmp_path / "compensator.fmu").write_bytes(compensators["2.0"].fmu.read_bytes())
    done = subprocess.run(
        [python, "-c", program(heading)], cwd=tmp_path, capture_output=True, text=True, check=False
    )

    assert done.returncode == 0, done.stderr

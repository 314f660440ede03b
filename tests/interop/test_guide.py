"""The guide to other tools: its table is that of the declarations, its programs run."""

from __future__ import annotations

import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from tests.costs import long_for
from tests.interop.experiment_in_fmu import Vectors
from tests.interop.other_tools import require
from tests.interop.variable_table import GUIDE, with_table

TRIED = {
    "FMPy": None,
    "PathSim": "pathsim_python",
    "CoFMPy": "cofmpy_python",
    "ecospy": "peer_python",
    "libcosimpy": "peer_python",
}


def program(heading: str, language: str = "python") -> str:
    """Return the program under a heading."""
    section = re.split(r"^### ", GUIDE.read_text(encoding="utf-8"), flags=re.MULTILINE)
    (text,) = (part for part in section if part.startswith(f"{heading}\n"))
    return re.search(rf"```{language}\n(.*?)```", text, re.DOTALL)[1]


def test_the_variable_table_is_that_of_the_declarations() -> None:
    guide = GUIDE.read_text(encoding="utf-8")

    assert guide == with_table(guide), "run: python tests/interop/variable_table.py"


@pytest.mark.slow
@pytest.mark.parametrize("heading", long_for(["PathSim", "CoFMPy"], TRIED))
def test_the_program_of_the_guide_runs(
    heading: str, compensators: dict[str, Vectors], request: pytest.FixtureRequest, tmp_path: Path
) -> None:
    fixture = TRIED[heading]
    python = sys.executable if fixture is None else request.getfixturevalue(fixture)
    (tmp_path / "compensator.fmu").write_bytes(compensators["2.0"].fmu.read_bytes())
    done = subprocess.run(
        [python, "-c", program(heading)], cwd=tmp_path, capture_output=True, text=True, check=False
    )

    assert done.returncode == 0, done.stderr


@pytest.mark.slow
@pytest.mark.parametrize("own_library", [False, True], ids=["as it is", "compiled from its sources"])
def test_the_c_host_of_the_guide_needs_the_fmu_alone(
    compensators: dict[str, Vectors], tmp_path: Path, own_library: bool
) -> None:
    """Also with a library that does not name libm, as `fmpy compile` makes it."""
    require(shutil.which("cc") and shutil.which("unzip"), "apt-get install gcc libc6-dev unzip")
    (tmp_path / "compensator.fmu").write_bytes(compensators["2.0"].fmu.read_bytes())
    (tmp_path / "host.c").write_text(program("C, Windows, ARM", "c"), encoding="utf-8")
    unpack, *rest = program("C, Windows, ARM", "sh").splitlines()
    library = "compensator/binaries/linux64/compensator.so"
    compile_it = f"cc -O2 -ffp-contract=off -shared -fPIC compensator/sources/*.c -o {library}"
    script = "\n".join(["set -e", unpack, *([compile_it] if own_library else []), *rest])
    done = subprocess.run(["sh", "-c", script], cwd=tmp_path, capture_output=True, text=True, check=False)

    assert done.returncode == 0, done.stderr
    assert done.stderr == ""
    assert "largest error of f_des" in done.stdout

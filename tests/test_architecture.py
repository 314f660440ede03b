"""The contracts on imports in `pyproject.toml`: packages are layers, no circle of files."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

PROJECT = Path(__file__).parents[1]
LINT = "import sys; from importlinter.cli import lint_imports; sys.exit(lint_imports(no_cache=True))"


def lint(folder: Path) -> subprocess.CompletedProcess[str]:
    return subprocess.run([sys.executable, "-c", LINT], cwd=folder, capture_output=True, text=True)


def test_every_package_uses_only_those_below_it():
    done = lint(PROJECT)

    assert done.returncode == 0, done.stdout
    assert "0 broken" in done.stdout


def test_an_import_that_runs_back_up_breaks_the_contract(tmp_path):
    """The same contracts on a copy of the package names, with one file that looks up."""
    contracts = (PROJECT / "pyproject.toml").read_text(encoding="utf-8")
    quietly = 'unmatched_ignore_imports_alerting = "none"\nignore_imports ='
    contracts = contracts.replace("ignore_imports =", quietly)  # the copy has no imports at all
    for package in ("dockloop", "fmu_sources", "master"):
        for source in (PROJECT / package).rglob("*.py"):
            copy = tmp_path / source.relative_to(PROJECT)
            copy.parent.mkdir(parents=True, exist_ok=True)
            copy.write_text("")
    (tmp_path / "pyproject.toml").write_text(contracts, encoding="utf-8")
    assert lint(tmp_path).returncode == 0

    (tmp_path / "master" / "fmi" / "values.py").write_text("import master.stepping.run\n")
    done = lint(tmp_path)

    assert done.returncode == 1
    assert "master.fmi.values -> master.stepping.run" in done.stdout

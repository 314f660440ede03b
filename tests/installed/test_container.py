"""The Dockerfile without a daemon: what it copies is there, and it has what the package needs."""

from __future__ import annotations

import re
import subprocess
import sys
import tomllib
from pathlib import Path

from hatchling.builders.wheel import WheelBuilder
from packaging.specifiers import SpecifierSet

from tests.conftest import PROJECT

TEXT = (PROJECT / "Dockerfile").read_text(encoding="utf-8")
ABOUT = tomllib.loads((PROJECT / "pyproject.toml").read_text(encoding="utf-8"))["project"]


def test_nothing_that_the_wheel_needs_is_kept_from_the_build() -> None:
    ignored = (PROJECT / ".dockerignore").read_text(encoding="utf-8").split()
    shipped = [Path(f.relative_path) for f in WheelBuilder(str(PROJECT)).recurse_included_files()]
    needed = [*shipped, Path("pyproject.toml"), Path(ABOUT["readme"]), *map(Path, ABOUT["license-files"])]
    patterns = [pattern.removeprefix("**/") for pattern in ignored]

    assert len(needed) > 500
    assert [path for path in needed if any(part in patterns for part in path.parts)] == []


def test_its_python_is_one_that_the_package_takes() -> None:
    versions = re.findall(r"^FROM python:([0-9.]+)-slim", TEXT, re.MULTILINE)

    assert len(set(versions)) == 1
    assert all(version in SpecifierSet(ABOUT["requires-python"]) for version in versions)
    assert f"Programming Language :: Python :: {versions[0]}" in ABOUT["classifiers"]


def test_its_extras_and_commands_are_those_of_the_package() -> None:
    extras = re.findall(r"\$\{wheel\}\[(\w+)\]", TEXT)
    commands = re.findall(r"^RUN (dockloop [^&\n]+)", TEXT, re.MULTILINE)

    assert extras
    assert set(extras) <= set(ABOUT["optional-dependencies"])
    assert len(commands) == 1
    for command in commands:
        program = [sys.executable, "-m", "master", *command.split()[1:], "--help"]
        done = subprocess.run(program, capture_output=True, text=True, check=False, cwd=PROJECT)

        assert done.returncode == 0, done.stderr


def test_it_runs_as_a_user_who_owns_the_folder_that_results_go_to() -> None:
    lines = [line.split() for line in TEXT.splitlines() if line]
    names = [line[0] for line in lines]
    last = {
        name: lines[len(names) - 1 - names[::-1].index(name)] for name in ("USER", "WORKDIR", "ENTRYPOINT")
    }

    assert last["USER"] != ["USER", "root"]
    assert f"chown -R {last['USER'][1]} {last['WORKDIR'][1]}" in TEXT
    assert names.index("USER") < names.index("ENTRYPOINT")

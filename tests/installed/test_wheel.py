"""What a stranger does with the wheel: run, build, diagnose, reproduce; no more is written."""

from __future__ import annotations

import json
import shutil
import subprocess
import sys
import tarfile
import zipfile
from pathlib import Path

import pytest

from tests.installed.conftest import Archives, Stranger
from tests.stubs.spring import SPRING

pytestmark = pytest.mark.long

PROJECT = Path(__file__).parents[2]


SYSTEM = """\
name: sprung
stop_time: 0.1
fmus:
  spring: {source: ./spring.fmu, start: {x: 0.5}}
"""


def written_below(folder: Path) -> set[str]:
    return {p.relative_to(folder).parts[0] for p in folder.rglob("*") if p.is_file()}


def test_the_wheel_owns_three_names_and_carries_all_that_is_committed(archives: Archives) -> None:
    names = zipfile.ZipFile(archives.wheel).namelist()
    committed = subprocess.run(
        ["git", "ls-files", "fmus", "configs", "master", "fmu_sources", "dockloop"],
        cwd=PROJECT,
        capture_output=True,
        text=True,
        check=True,
    ).stdout.split()
    moved = {f"dockloop/{n}" if n.startswith(("fmus/", "configs/")) else n for n in committed}
    assert {n.partition("/")[0] for n in names if ".dist-info/" not in n} == {
        "dockloop",
        "fmu_sources",
        "master",
    }
    assert moved - set(names) == {"dockloop/configs/measured/.gitignore"}


def test_the_sdist_holds_sources_tests_and_documents(archives: Archives) -> None:
    with tarfile.open(archives.sdist) as archive:
        tops = {name.split("/")[1] for name in archive.getnames() if "/" in name}

    assert {
        "fmus",
        "fmu_sources",
        "master",
        "dockloop",
        "configs",
        "tests",
        "docs",
        "README.md",
        "LICENSE",
    } <= tops


def test_a_shipped_configuration_runs_by_its_name_with_the_shipped_fmus(
    stranger: Stranger, tmp_path: Path
) -> None:
    done = stranger.dockloop("run", "low_frequency", "--json")
    here = [sys.executable, "-m", "master", "run", "configs/low_frequency.yaml", "--output", str(tmp_path)]
    subprocess.run(here, cwd=PROJECT, check=True, capture_output=True)
    found = stranger.folder / "work" / json.loads(done.stdout)["files"]["csv"]

    assert json.loads(done.stdout)["status"] == "completed"
    assert "flavour" not in done.stderr
    assert written_below(stranger.folder / "home" / ".cache" / "dockloop") == {"compiled", "stamps"}
    assert found.read_bytes() == (tmp_path / "result.csv").read_bytes()


def test_doctor_says_that_it_is_a_wheel_with_its_fmus(stranger: Stranger) -> None:
    found = json.loads(stranger.dockloop("doctor", "--json").stdout)

    assert (found["installed_as"], found["cache"]["writable"]) == ("wheel", True)
    assert set(found["fmus"].values()) == {"released"}
    assert found["extras"]["native"]["missing"] == []
    assert found["extras"]["native"]["command"] == "pip install 'dockloop[native]'"


def test_examples_are_copied_with_what_they_name_and_are_right(stranger: Stranger) -> None:
    stranger.dockloop("examples", "docking_rig", "hexapod/drag")
    work = stranger.folder / "work"

    assert (work / "measured/recordings/docking_rig.csv").is_file()
    stranger.dockloop("check", "experiment_1000kg.yaml")
    stranger.dockloop("check", "hexapod/drag.yaml")


def test_a_model_is_built_by_its_path_and_runs(stranger: Stranger) -> None:
    work = stranger.folder / "work"
    (work / "spring.py").write_text(SPRING, encoding="utf-8")
    (work / "sprung.yaml").write_text(SYSTEM, encoding="utf-8")
    stranger.dockloop("build", "spring.py")
    stranger.dockloop("run", "sprung.yaml", "--output", "sprung")
    last = (work / "sprung" / "result.csv").read_text(encoding="utf-8").splitlines()[-1]

    assert float(last.split(",")[1]) == 50.0


def test_the_small_shipped_case_is_diagnosed(stranger: Stranger) -> None:
    found = json.loads(stranger.dockloop("diagnose", "first_case", "--json").stdout)

    assert found["verdict"] == "traced"
    assert "coulomb" in found["sentence"]


def test_a_claim_and_a_figure_of_the_paper_are_reproduced(stranger: Stranger) -> None:
    """The whole takes minutes: `tests/systems/test_reproduce.py` has it."""
    found = json.loads(stranger.dockloop("reproduce", "--only", "ideal", "--only", "17", "--json").stdout)

    assert {row["id"].partition(".")[0] for row in found["claims"]} == {"ideal"}
    assert found["changed"] == []
    assert list(found["files"]["figures"]) == ["17"]
    assert Path(stranger.folder, "work", found["files"]["page"]).is_file()


def test_a_home_that_cannot_be_written_costs_time_alone(stranger: Stranger) -> None:
    done = stranger.dockloop("run", "low_frequency", "--stop-time", "0.1", home="nowhere/at/all")

    assert "Traceback" not in done.stderr


def test_a_checkout_that_cannot_be_written_runs(stranger: Stranger, readable_folder: Path) -> None:
    checkout = readable_folder / "checkout"
    for name in ("master", "fmu_sources", "fmus", "configs", "dockloop"):
        shutil.copytree(
            PROJECT / name, checkout / name, ignore=shutil.ignore_patterns("__pycache__", "local")
        )
    shutil.copy(PROJECT / "LICENSE", checkout)
    before = sorted(checkout.rglob("*"))
    output = str(stranger.folder / "work" / "from_checkout")
    run = ("run", "configs/low_frequency.yaml", "--stop-time", "0.1", "--output", output)
    done = stranger.run(str(stranger.python), "-m", "master", *run, cwd=checkout)

    assert done.returncode == 0, done.stderr
    assert sorted(checkout.rglob("*")) == before

"""The compensator FMU in other tools gives the reference outputs that it carries."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
import zipfile
from pathlib import Path

import numpy as np
import pytest
from fmpy import read_model_description

from tests.interop.container import build_container
from tests.interop.experiment_in_fmu import BOUND, FOLDER, Vectors, in_fmpy
from tests.interop.other_tools import importable, require, unpack_library

pytestmark = pytest.mark.slow

ZIG = [sys.executable, "-m", "ziglang", "cc"]
ZIG_EXTRA = "pip install -e '.[native]'"


def in_peer(python: Path, script: str, given: Vectors, folder: Path, *more: str) -> np.ndarray:
    experiment = given.as_json(folder / "experiment.json")
    command = [str(python), str(Path(__file__).with_name(script)), str(given.fmu), str(experiment), *more]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return np.array(json.loads(done.stdout[done.stdout.index("[[") :]))


def in_host(
    command: list[str], library: Path, given: Vectors, folder: Path, *more: str, **environment: str
) -> np.ndarray:
    """Run the plain C host in the folder of its files, so that all paths are short and relative."""
    description = read_model_description(given.fmu)
    version = description.fmiVersion[0]
    token = description.guid if version == "2" else description.instantiationToken
    given.as_text(folder / "experiment.txt")
    arguments = [*command, version, library.relative_to(folder).as_posix(), token, "experiment.txt", *more]
    environment = {**os.environ, **environment}
    done = subprocess.run(arguments, cwd=folder, capture_output=True, text=True, env=environment, check=False)
    assert done.returncode == 0, done.stderr
    return np.array([[float(value) for value in line.split(",")] for line in done.stdout.split()])


def folder_for(given: Vectors, fmi2: str, fmi3: str) -> str:
    return fmi2 if read_model_description(given.fmu).fmiVersion.startswith("2") else fmi3


def test_fmpy(given: Vectors) -> None:
    assert given.largest_deviation(in_fmpy(given, given.fmu, given.parameters)) <= BOUND


def test_the_container_fmu_of_fmpy(compensators: dict[str, Vectors], tmp_path: Path) -> None:
    given = compensators["2.0"]
    container = build_container(given, tmp_path)

    assert given.largest_deviation(in_fmpy(given, container, {})) <= BOUND


def test_ecospy(given: Vectors, peer_python: Path, tmp_path: Path) -> None:
    imported = subprocess.run([peer_python, "-c", "import ecospy"], capture_output=True, check=False)
    require(imported.returncode == 0, "apt-get install libtbb12")

    assert given.largest_deviation(in_peer(peer_python, "run_in_ecos.py", given, tmp_path)) <= BOUND


def test_libcosimpy(compensators: dict[str, Vectors], peer_python: Path, tmp_path: Path) -> None:
    given = compensators["2.0"]
    after_each_step = in_peer(peer_python, "run_in_cosim.py", given, tmp_path)

    assert given.largest_deviation(after_each_step, first=1) <= BOUND


def test_fmpy_on_the_command_line(given: Vectors, tmp_path: Path) -> None:
    with zipfile.ZipFile(given.fmu) as archive:
        (tmp_path / "in.csv").write_bytes(archive.read(f"{FOLDER}/compensator_in.csv"))
    starts = [text for name, value in given.parameters.items() for text in (name, repr(value))]
    command = [sys.executable, "-m", "fmpy", "simulate", str(given.fmu), "--stop-time", "0.25"]
    command += ["--output-interval", repr(given.step), "--start-values", *starts, "--input-file", "in.csv"]
    command += ["--output-variables", *given.output_names, "--output-file", "out.csv"]
    subprocess.run(command, cwd=tmp_path, check=True, capture_output=True)
    found = np.genfromtxt(tmp_path / "out.csv", delimiter=",", names=True)

    assert given.largest_deviation(np.column_stack([found[n] for n in given.output_names])) <= BOUND


@pytest.mark.long
@pytest.mark.parametrize("package", ["pathsim.blocks", "pathsim_fmi"])
def test_pathsim(given: Vectors, pathsim_python: Path, tmp_path: Path, package: str) -> None:
    got = in_peer(pathsim_python, "run_in_pathsim.py", given, tmp_path, package)

    assert given.largest_deviation(got) <= BOUND


@pytest.mark.long
def test_cofmpy(given: Vectors, cofmpy_python: Path, tmp_path: Path) -> None:
    after_each_step = in_peer(cofmpy_python, "run_in_cofmpy.py", given, tmp_path)

    assert given.largest_deviation(after_each_step, first=1) <= BOUND


def test_a_plain_c_host(given: Vectors, host, tmp_path: Path) -> None:
    require(shutil.which("cc"), "apt-get install gcc libc6-dev")
    library = unpack_library(given.fmu, folder_for(given, "linux64", "x86_64-linux"), tmp_path)
    program = host(["cc", "-Wall", "-Wextra", "-Werror"], "host")

    assert given.largest_deviation(in_host([str(program)], library, given, tmp_path)) <= BOUND


def test_the_plain_c_host_needs_nothing_but_the_c_library(given: Vectors, host, tmp_path: Path) -> None:
    require(shutil.which("cc") and shutil.which("nm"), "apt-get install gcc libc6-dev binutils")
    library = unpack_library(given.fmu, folder_for(given, "linux64", "x86_64-linux"), tmp_path)
    for file in (host(["cc", "-Wall", "-Wextra", "-Werror"], "host"), library):
        dynamic = subprocess.run(["readelf", "-d", file], capture_output=True, text=True, check=True).stdout
        needed = {line.split("[")[1].rstrip("]") for line in dynamic.splitlines() if "(NEEDED)" in line}
        symbols = subprocess.run(["nm", "-D", file], capture_output=True, text=True, check=True).stdout

        assert needed <= {"libc.so.6", "libm.so.6", "libdl.so.2"}
        assert "Py" not in symbols


@pytest.mark.long  # the first executable for Windows compiles the C library of its target
def test_the_windows_library_under_wine(given: Vectors, host, wine_prefix: Path, tmp_path: Path) -> None:
    wine = shutil.which("wine64", path=os.environ["PATH"] + ":/usr/lib/wine")
    require(wine, "apt-get install wine64")
    require(importable("ziglang"), ZIG_EXTRA)
    library = unpack_library(given.fmu, folder_for(given, "win64", "x86_64-windows"), tmp_path)
    program = host([*ZIG, "-target", "x86_64-windows-gnu"], "host.exe")
    got = in_host(
        [str(wine), str(program)], library, given, tmp_path, WINEPREFIX=str(wine_prefix), WINEDEBUG="-all"
    )

    assert given.largest_deviation(got) <= BOUND


def test_the_arm_library_under_qemu(given: Vectors, host, tmp_path: Path) -> None:
    qemu, sysroot = shutil.which("qemu-aarch64-static"), Path("/usr/aarch64-linux-gnu")
    require(qemu and sysroot.exists(), "apt-get install qemu-user-static libc6-arm64-cross")
    require(importable("ziglang"), ZIG_EXTRA)
    library = unpack_library(given.fmu, folder_for(given, "linuxaarch64", "aarch64-linux"), tmp_path)
    program = host([*ZIG, "-target", "aarch64-linux-gnu.2.17"], "host_arm")
    got = in_host([str(qemu), "-L", str(sysroot), str(program)], library, given, tmp_path)

    assert given.largest_deviation(got) <= BOUND


@pytest.fixture(scope="session")
def wine_prefix(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder where wine keeps what it needs."""
    return tmp_path_factory.mktemp("wine")

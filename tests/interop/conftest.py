"""The compensator FMU for all platforms, a Python of their own for peers, and a compiled C host."""

from __future__ import annotations

import fcntl
import hashlib
import subprocess
import sys
import sysconfig
from collections.abc import Callable
from pathlib import Path

import pytest

from fmu_sources.composed import registry
from fmu_sources.export import build
from fmu_sources.export.native_flavour import native_sources, pack_native, release_binaries
from fmu_sources.export.places import FMU_FOLDER
from tests.interop.experiment_in_fmu import Vectors, vectors
from tests.interop.other_tools import importable, require

PROJECT = Path(__file__).parents[2]
PEERS = ("ecospy>=0.7.2,<0.8", "libcosimpy>=0.0.6,<0.1")
PATHSIM = ("pathsim>=0.27,<0.28", "pathsim-fmi>=0.1.1,<0.2")
COFMPY = ("cofmupy>=1.0,<1.1",)
OURS = sysconfig.get_path("purelib")
FLAVOURS = {"2.0": "native", "3.0": "fmi3"}


@pytest.fixture(scope="session")
def compensators(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Vectors]:
    """FMI version to the compensator FMU for all platforms, committed if it is current, else built."""
    committed = {v: build.target("compensator", flavour) for v, flavour in FLAVOURS.items()}
    if all(t.path.is_relative_to(FMU_FOLDER) and t.is_current() for t in committed.values()):
        return {v: vectors(t.path) for v, t in committed.items()}
    require(importable("casadi") and importable("ziglang"), "pip install -e '.[native]'")
    sources = native_sources(registry.load("compensator"), registry.model_files()["compensator"])
    binaries = release_binaries(sources)
    found = {}
    for version in FLAVOURS:
        path = tmp_path_factory.mktemp("fmus") / "compensator.fmu"
        path.write_bytes(pack_native(sources, binaries, version))
        found[version] = vectors(path)
    return found


@pytest.fixture(params=FLAVOURS)
def given(request: pytest.FixtureRequest, compensators: dict[str, Vectors]) -> Vectors:
    """The compensator with its vectors, in FMI 2.0 and in FMI 3.0."""
    return compensators[request.param]


def python_with(packages: tuple[str, ...]) -> Path:
    """
    Python of an environment of its own for tools whose requirements clash with ours; made once.

    What it does not have it takes from the environment of the tests, so only what clashes is installed anew.
    """
    about = hashlib.sha256(repr((packages, OURS, sys.version_info)).encode()).hexdigest()[:12]
    folder = PROJECT / "build" / f"peers-{about}"
    folder.mkdir(parents=True, exist_ok=True)
    with (folder / "lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)  # test processes side by side make it once
        if not (folder / "complete").exists():
            subprocess.run([sys.executable, "-m", "venv", "--clear", str(folder / "venv")], check=True)
            [theirs] = (folder / "venv").glob("lib/python*/site-packages")
            (theirs / "ours.pth").write_text(f"{OURS}\n", encoding="utf-8")  # found after their own
            pip = [folder / "venv" / "bin" / "python", "-m", "pip", "install", "-q", "--no-cache-dir"]
            done = subprocess.run([*pip, *packages], check=False)
            require(done.returncode == 0, "a package registry that has " + ", ".join(packages))
            (folder / "complete").touch()
    return folder / "venv" / "bin" / "python"


@pytest.fixture(scope="session")
def peer_python() -> Path:
    """Python with ecospy and libcosimpy."""
    return python_with(PEERS)


@pytest.fixture(scope="session")
def pathsim_python() -> Path:
    """Python with PathSim and pathsim-fmi."""
    return python_with(PATHSIM)


@pytest.fixture(scope="session")
def cofmpy_python() -> Path:
    """Python with CoFMPy, which asks for another FMPy than pathsim-fmi."""
    return python_with(COFMPY)


@pytest.fixture(scope="session")
def host(tmp_path_factory: pytest.TempPathFactory) -> Callable[[list[str], str], Path]:
    """Compile the plain C host with a compiler, once for each file name."""
    import fmpy

    headers = Path(fmpy.__file__).parent / "c-code"
    folder = tmp_path_factory.mktemp("host")

    def compiled(compiler: list[str], name: str) -> Path:
        path = folder / name
        if not path.exists():
            source = Path(__file__).with_name("host.c")
            # -s as in the release: zig compiles the libraries of a target again for other options
            libraries = [] if name.endswith(".exe") else ["-ldl"]
            command = [*compiler, "-O2", "-s", "-I", str(headers), str(source), *libraries, "-o", str(path)]
            subprocess.run(command, check=True, capture_output=True)
        return path

    return compiled

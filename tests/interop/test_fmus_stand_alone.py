"""Every FMU: valid, the same bytes each time, nothing of Python in it; and runs need no build tools."""

from __future__ import annotations

import hashlib
import os
import subprocess
import sys
import zipfile
from functools import cache
from io import BytesIO
from pathlib import Path

import pytest
from fmpy.validation import validate_fmu

from fmu_sources.composed import registry
from fmu_sources.export import build
from fmu_sources.export.native_flavour import host_binaries, native_sources, pack_native
from fmu_sources.export.python_flavour import build_python
from fmu_sources.export.reference_data import agreement
from fmu_sources.export.release import release_models
from tests.interop.experiment_in_fmu import in_fmpy, vectors
from tests.interop.other_tools import importable, require

pytestmark = pytest.mark.slow

VERSIONS = ("2.0", "3.0")
LIBC = {"calloc", "free", "memcpy", "memset", "memcmp", "bcmp", "strcmp", "strcpy", "strlen", "snprintf"}
LIBC |= {"vsnprintf", "__snprintf_chk", "__vsnprintf_chk", "strtod", "strtol", "__stack_chk_fail", "malloc"}
LIBM = {"cos", "sin", "sincos", "tan", "tanh", "exp", "log", "sqrt", "floor", "ceil", "nearbyint", "fabs"}
LINKER = {"__cxa_finalize", "__gmon_start__", "_ITM_deregisterTMCloneTable", "_ITM_registerTMCloneTable"}

each_model = pytest.mark.parametrize("name", release_models())


@cache
def fmus(name: str) -> dict[str, bytes]:
    """Build a model for this machine, once; FMI version to FMU."""
    require(importable("casadi"), "pip install -e '.[native]'")
    sources = native_sources(registry.load(name), registry.model_files()[name])
    binaries = host_binaries(sources)
    return {version: pack_native(sources, binaries, version) for version in VERSIONS}


@each_model
def test_native_fmus_are_valid(name: str, tmp_path: Path) -> None:
    for version, content in fmus(name).items():
        path = tmp_path / f"{name}_{version}.fmu"
        path.write_bytes(content)

        assert validate_fmu(path) == []


@each_model
def test_fmpy_gets_the_reference_outputs_of_every_fmu(name: str, tmp_path: Path) -> None:
    for version, content in fmus(name).items():
        path = tmp_path / f"{name}_{version}.fmu"
        path.write_bytes(content)
        given = vectors(path)

        assert given.largest_deviation(in_fmpy(given, path, given.parameters)) <= agreement(
            registry.load(name)
        )


@each_model
def test_a_python_fmu_is_valid_and_builds_to_the_same_bytes(name: str, tmp_path: Path) -> None:
    path = tmp_path / f"{name}.fmu"
    model, file = registry.load(name), registry.model_files()[name]
    path.write_bytes(build_python(model, file))

    assert validate_fmu(path) == []
    assert build_python(model, file) == path.read_bytes()


@each_model
def test_the_library_needs_the_c_library_only(name: str, tmp_path: Path) -> None:
    with zipfile.ZipFile(BytesIO(fmus(name)["2.0"])) as archive:
        library = archive.extract(f"binaries/linux64/{name}.so", tmp_path)
    done = subprocess.run(["nm", "-D", "-u", library], capture_output=True, text=True, check=True)
    undefined = {line.split()[-1].partition("@")[0] for line in done.stdout.splitlines()}

    assert undefined <= LIBC | LIBM | LINKER


@pytest.mark.long
@each_model
def test_builds_in_three_processes_give_the_same_token_and_bytes(name: str) -> None:
    code = f"""
import hashlib
from fmu_sources.composed import registry
from fmu_sources.export.native_flavour import host_binaries, native_sources, pack_native
s = native_sources(registry.load({name!r}), registry.model_files()[{name!r}])
b = host_binaries(s)
print([hashlib.sha256(pack_native(s, b, v)).hexdigest() for v in ("2.0", "3.0")])
"""
    here = str([hashlib.sha256(content).hexdigest() for content in fmus(name).values()])
    there = {
        run_python(code, PYTHONHASHSEED=seed, TZ=zone) for seed, zone in (("1", "UTC"), ("2", "Asia/Tokyo"))
    }

    assert {text.strip() for text in there} == {here}


BLOCKED = """
import sys


class Blocker:
    def find_spec(self, name, path=None, target=None):
        if name.partition(".")[0] in {"casadi", "ziglang"}:
            raise ModuleNotFoundError(name)


sys.meta_path.insert(0, Blocker())
import shutil
assert shutil.which("cc") is None and shutil.which("gcc") is None
from master.__main__ import main
main()
"""


@pytest.mark.parametrize("flavour", ["native", "fmi3"])
def test_a_run_needs_no_compiler_no_casadi_and_no_zig(flavour: str, tmp_path: Path) -> None:
    config = registry.ROOT.parent / "configs" / "low_frequency.yaml"
    for name in sources_of(config):
        wanted = build.target(name, flavour)
        if not wanted.is_current():
            require(importable("casadi"), "pip install -e '.[native]'")
            build.build(wanted)
    arguments = ["run", str(config), "--stop-time", "0.05", "--flavour", flavour, "--output", str(tmp_path)]
    run_python(BLOCKED, *arguments, PATH=str(tmp_path / "nothing"))

    assert list(tmp_path.rglob("*.csv"))


def sources_of(config: Path) -> list[str]:
    """Models that a configuration names."""
    import yaml

    entries = yaml.safe_load(config.read_text(encoding="utf-8"))["fmus"].values()
    return [entry["source"] for entry in entries]


def run_python(code: str, *arguments: str, **environment: str) -> str:
    """Run code in a process of its own; give what it prints."""
    done = subprocess.run(
        [sys.executable, "-c", code, *arguments],
        capture_output=True,
        text=True,
        cwd=registry.ROOT.parent,
        env={**os.environ, **environment},
        check=False,
    )
    assert done.returncode == 0, done.stderr[-3000:] + done.stdout[-1000:]
    return done.stdout

"""What the builds are: the same bytes every time, nothing but libc and libm needed, clear errors."""

from __future__ import annotations

import importlib.util
import platform
import re
import shutil
import struct
import subprocess
import sys
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from xml.etree import ElementTree as ET

import pytest

from fmu_sources.export import native
from fmu_sources.export.native import compile as compiling
from fmu_sources.export.native.codegen import fmi_headers
from fmu_sources.export.native.fat import join
from fmu_sources.export.native.platforms import LINUX, RELEASE
from fmu_sources.framework.model import Model
from tests.fmu_sources.export.native.native_library import GUID
from tests.fmu_sources.export.native.native_model import MODEL

LIBC_AND_LIBM = {"cos", "sin", "sincos", "tan", "tanh", "exp", "log", "floor", "ceil", "nearbyint"} | {
    "calloc", "malloc", "free", "memcpy", "memset", "memcmp", "bcmp", "strcmp", "strcpy", "strlen",
    "snprintf", "vsnprintf", "__snprintf_chk", "__vsnprintf_chk", "strtod", "strtol", "__stack_chk_fail",
}  # fmt: skip
WEAK_OF_THE_LINKER = {
    "__cxa_finalize",
    "__gmon_start__",
    "_ITM_deregisterTMCloneTable",
    "_ITM_registerTMCloneTable",
}

needs_zig = pytest.mark.skipif(importlib.util.find_spec("ziglang") is None, reason="needs ziglang")


def symbols(path: Path, kind: str) -> set[str]:
    done = subprocess.run(["nm", "-D", kind, str(path)], capture_output=True, text=True, check=True)
    return {line.split()[-1].partition("@")[0] for line in done.stdout.splitlines()}


def test_the_same_model_gives_the_same_sources() -> None:
    assert native.generate(MODEL, GUID) == native.generate(MODEL, GUID)


def test_two_builds_give_the_same_bytes() -> None:
    sources = native.generate(MODEL, GUID)

    assert native.compile_host(sources, "specimen") == native.compile_host(sources, "specimen")


def test_the_library_needs_libc_and_libm_only(library: Callable[[Model], Path]) -> None:
    undefined = symbols(library(MODEL), "--undefined-only")

    assert undefined <= LIBC_AND_LIBM | WEAK_OF_THE_LINKER


def test_the_library_exports_all_functions_of_both_versions_and_nothing_else(
    library: Callable[[Model], Path],
) -> None:
    headers = fmi_headers()
    fmi3 = re.findall(rb"FMI3_Export \w+\s+(fmi3\w+);", headers["fmi3Functions.h"])
    exported = symbols(library(MODEL), "--defined-only")

    assert {name for name in exported if name.startswith("fmi3")} == {name.decode() for name in fmi3}
    assert len(fmi3) == 75
    assert len({name for name in exported if name.startswith("fmi2")}) == 34
    assert len(exported) == 34 + 75


def test_only_creating_an_instance_and_saving_a_state_allocate(tmp_path: Path) -> None:
    sources = native.generate(MODEL, GUID)
    allocating = {name for name, text in sources.items() if re.search(rb"\b(malloc|calloc|realloc)\(", text)}

    assert allocating == {"instance.c", "saved_state.c"}


@pytest.mark.skipif(shutil.which("gcc") is None, reason="needs gcc")
def test_the_sources_compile_without_a_warning(tmp_path: Path) -> None:
    for name, content in native.generate(MODEL, GUID).items():
        (tmp_path / name).write_bytes(content)
    flags = [
        "-std=c11",
        "-fsyntax-only",
        "-Wall",
        "-Wextra",
        "-Wpedantic",
        "-Wshadow",
        "-Wconversion",
        "-Werror",
    ]
    files = sorted(str(path) for path in tmp_path.glob("*.c"))

    subprocess.run(["gcc", *flags, "-Wno-sign-conversion", *files], check=True)


def test_the_build_description_names_every_c_file() -> None:
    sources = native.generate(MODEL, GUID)
    root = ET.fromstring(native.build_description(sources, "specimen"))

    assert [e.get("name") for e in root.iter("SourceFile")] == native.c_files(sources)
    assert {"fmi2.c", "fmi3.c", "model_equations.c"} <= set(native.c_files(sources))


def test_a_missing_build_extra_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: None)
    with pytest.raises(native.MissingToolError) as error:
        native.generate(MODEL, GUID)

    assert str(error.value) == ("native build: casadi is not installed, expected: pip install -e '.[native]'")


def test_without_compiler_and_zig_the_error_names_zig(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: None)
    monkeypatch.setattr(shutil, "which", lambda name: None)
    with pytest.raises(native.MissingToolError, match="ziglang"):
        native.compile_host({}, "specimen")


def test_a_compiler_error_is_passed_on() -> None:
    with pytest.raises(native.NativeBuildError, match="the compiler failed"):
        native.compile_host({"a.c": b"not C"}, "specimen")


@pytest.fixture
def compilations(monkeypatch: pytest.MonkeyPatch) -> list[compiling.Compilation]:
    """What a release began: compilers that would take minutes, but for the first platform's, which fails."""
    begun: list[compiling.Compilation] = []
    compiler = f"import sys, time; sys.argv[2] == {RELEASE[0].zig_target!r} and sys.exit(1); time.sleep(600)"

    class Noted(compiling.Compilation):
        def __init__(
            self, sources: Mapping[str, bytes], command: Sequence[str], name: str, extra: Sequence[str]
        ) -> None:
            super().__init__(sources, command, name, extra)
            begun.append(self)

    monkeypatch.setattr(compiling, "_zig", lambda: [sys.executable, "-c", compiler])
    monkeypatch.setattr(compiling, "Compilation", Noted)
    return begun


def test_a_release_that_fails_on_one_platform_ends_the_compilers_of_the_others(
    compilations: list[compiling.Compilation],
) -> None:
    with pytest.raises(native.NativeBuildError, match="the compiler failed"):
        native.compile_release({}, "specimen")

    assert [compilation.is_done() for compilation in compilations] == [True] * len(RELEASE)


def test_an_interrupt_while_a_release_waits_for_one_compiler_ends_all(
    compilations: list[compiling.Compilation], monkeypatch: pytest.MonkeyPatch
) -> None:
    def interrupted(compilation: compiling.Compilation) -> bytes:
        raise KeyboardInterrupt

    monkeypatch.setattr(compiling.Compilation, "library", interrupted)

    with pytest.raises(KeyboardInterrupt):
        native.compile_release({}, "specimen")

    assert [compilation.is_done() for compilation in compilations] == [True] * len(RELEASE)


def test_a_fat_library_points_at_its_slices() -> None:
    slices = [struct.pack("<III", 0xFEEDFACF, cpu, 3) + bytes([cpu]) * 5000 for cpu in (7, 12)]
    both = join(slices)
    heads = [struct.unpack_from(">IIIII", both, 8 + 20 * i) for i in range(2)]

    assert struct.unpack_from(">II", both) == (0xCAFEBABE, 2)
    assert [both[offset : offset + size] for _, _, offset, size, _ in heads] == slices
    assert [(cpu, offset % 2**align) for cpu, _, offset, _, align in heads] == [(7, 0), (12, 0)]


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="names of Linux")
def test_the_host_has_a_folder_in_both_versions(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(platform, "machine", lambda: "x86_64")

    assert native.host_folders() == (("linux64", ".so"), ("x86_64-linux", ".so"))


@needs_zig
@pytest.mark.long
def test_two_release_builds_give_the_same_bytes_for_every_platform() -> None:
    sources = native.generate(MODEL, GUID)
    first = native.compile_release(sources, "specimen")

    assert native.compile_release(sources, "specimen") == first
    assert len(first) == 2 * len(RELEASE) - 1
    assert sorted(native.of_version(first, "2.0")) == [
        "binaries/darwin64/specimen.dylib",
        "binaries/linux64/specimen.so",
        "binaries/linuxaarch64/specimen.so",
        "binaries/win64/specimen.dll",
    ]
    assert len(native.of_version(first, "3.0")) == len(RELEASE)
    assert not any(b"/tmp/" in binary for binary in first.values())


@needs_zig
@pytest.mark.slow
def test_the_release_library_for_linux_needs_glibc_2_17_at_most(tmp_path: Path) -> None:
    path = tmp_path / "specimen.so"
    path.write_bytes(compiling.compile_for(LINUX, native.generate(MODEL, GUID), "specimen"))
    done = subprocess.run(
        ["nm", "-D", "--undefined-only", str(path)], capture_output=True, text=True, check=True
    )
    versions = {tuple(map(int, v.split("."))) for v in re.findall(r"@GLIBC_([\d.]+)", done.stdout)}

    assert symbols(path, "--undefined-only") <= LIBC_AND_LIBM | WEAK_OF_THE_LINKER
    assert max(versions) <= (2, 17)

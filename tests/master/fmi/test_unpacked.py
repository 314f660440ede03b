import platform
import sys
import zipfile
from dataclasses import replace
from pathlib import Path

import fmpy
import pytest

from master.errors import ConfigError
from master.fmi import unpacked
from tests.stubs import clock


@pytest.fixture
def described(tmp_path):
    with zipfile.ZipFile(tmp_path / "a.fmu", "w") as archive:
        archive.writestr("binaries/plan9/a.so", b"")
    return replace(clock().description("a"), path=tmp_path / "a.fmu")


@pytest.fixture
def unpack(tmp_path):
    made = []

    def function(description):
        made.append(tmp_path / f"unpacked{len(made)}")
        made[-1].mkdir()
        return str(made[-1])

    return function


def test_instances_of_one_fmu_share_a_folder_until_the_last_is_gone(described, unpack):
    first, second = (unpacked.acquire(described, unpack) for _ in range(2))
    assert first == second
    unpacked.release(first)
    assert Path(first).is_dir()
    unpacked.release(second)
    assert not Path(first).exists()


def test_a_folder_that_is_kept_serves_the_next_runs_and_goes_at_the_end(described, unpack):
    with unpacked.kept():
        first = unpacked.acquire(described, unpack)
        unpacked.release(first)
        assert unpacked.acquire(described, unpack) == first
        unpacked.release(first)
        assert Path(first).is_dir()
    assert not Path(first).exists()


def test_a_folder_that_is_in_use_outlasts_the_keeping(described, unpack):
    with unpacked.kept():
        first = unpacked.acquire(described, unpack)
    assert Path(first).is_dir()
    unpacked.release(first)
    assert not Path(first).exists()


def test_a_file_that_has_changed_is_another_fmu(described, unpack):
    first = unpacked.acquire(described, unpack)
    described.path.write_bytes(described.path.read_bytes() + b" ")
    second = unpacked.acquire(described, unpack)

    assert first != second
    unpacked.release(first)
    unpacked.release(second)


@pytest.mark.parametrize("flag", ["once_per_process", "needs_execution_tool"])
def test_an_fmu_that_cannot_share_has_a_folder_of_its_own(described, unpack, flag):
    alone = replace(described, **{flag: True})
    first, second = (unpacked.acquire(alone, unpack) for _ in range(2))

    assert first != second
    unpacked.release(first)
    assert not Path(first).exists()
    assert Path(second).is_dir()


def test_a_platform_without_binary_is_named(described):
    with pytest.raises(ConfigError, match=r"a\.fmu: no binary for this platform, got plan9, expected "):
        unpacked.require_runnable([described])


def elf(kind=3, machine=62):
    return b"\x7fELF\x02\x01\x01" + bytes(9) + kind.to_bytes(2, "little") + machine.to_bytes(2, "little")


HERE = {"x86_64": 62, "aarch64": 183}.get(platform.machine(), 0)
OTHER, OTHER_NAME = (183, "aarch64") if HERE == 62 else (62, "x86_64")


@pytest.mark.skipif(not sys.platform.startswith("linux") or not HERE, reason="reads libraries of Linux")
@pytest.mark.parametrize(
    ("name", "content", "problem"),
    [
        ("b.so", elf(machine=HERE), "no binary of the name in its description, got b.so, expected a.so"),
        ("a.so", b"MZ" + bytes(30), "a.so: not a library, expected a shared object of Linux (ELF)"),
        ("a.so", b"", "a.so: not a library, expected a shared object of Linux (ELF)"),
        ("a.so", elf(1, HERE), "a.so: not a shared library, got an ELF file of type 1, expected 3"),
        ("a.so", elf(3, OTHER), f"a.so: a library of another machine, got {OTHER_NAME}, expected "),
        ("a.so", elf(3, 999), "a.so: a library of another machine, got machine number 999, expected "),
    ],
)
def test_a_binary_that_cannot_be_loaded_here_is_refused_without_loading_it(described, name, content, problem):
    with zipfile.ZipFile(described.path, "w") as archive:
        archive.writestr(f"binaries/{fmpy.platform}/{name}", content)

    with pytest.raises(ConfigError) as caught:
        unpacked.require_runnable([described])
    assert problem in str(caught.value)


def test_faults_of_all_fmus_are_told_at_once(described, tmp_path):
    other = replace(described, path=tmp_path / "none.fmu")

    with pytest.raises(ConfigError) as caught:
        unpacked.require_runnable([described, other, described])
    assert len(caught.value.problems) == 2


def test_an_unpacked_folder_is_unpacked_as_its_archive_is(tmp_path):
    for name in ("modelDescription.xml", f"binaries/{fmpy.platform}/a.so", "resources/data", "sources/a.c"):
        (tmp_path / "fmu" / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / "fmu" / name).write_bytes(elf(machine=HERE))
    description = replace(clock().description("a"), path=tmp_path / "fmu")
    folder = unpacked.acquire(description, unpacked.unpack)

    assert sorted(p.name for p in Path(folder).rglob("*") if p.is_file()) == [
        "a.so",
        "data",
        "modelDescription.xml",
    ]
    unpacked.release(folder)
    assert (tmp_path / "fmu" / "sources" / "a.c").is_file()

import zipfile
from dataclasses import replace
from pathlib import Path

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

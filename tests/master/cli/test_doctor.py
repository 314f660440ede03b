"""`dockloop doctor` tells what is installed, what is missing for which work, and where caches are."""

from __future__ import annotations

import importlib.metadata
import json

import pytest
from click.testing import CliRunner

from fmu_sources.export.places import cache_folder
from fmu_sources.export.release import release_models
from master import installation
from master.cli import main


@pytest.fixture
def told():
    def call(*options):
        done = CliRunner().invoke(main, ["doctor", *options])
        assert done.exit_code == 0, done.output
        return done.stdout

    return call


@pytest.fixture
def cache(tmp_path, monkeypatch):
    """A cache of 2 MB in a folder of this test."""
    folder = tmp_path / "cache"
    folder.mkdir()
    (folder / "built.fmu").write_bytes(bytes(2_000_000))
    monkeypatch.setenv("DOCKLOOP_CACHE", str(folder))
    cache_folder.cache_clear()
    yield folder
    cache_folder.cache_clear()


def test_versions_are_those_of_the_packages(told):
    found = json.loads(told("--json"))

    assert {"numpy", "pyarrow", "fmpy"} <= set(found["packages"])
    assert all(version == importlib.metadata.version(name) for name, version in found["packages"].items())
    assert found["installed_as"] == "checkout"
    assert found["fmus"] == dict.fromkeys(release_models(), "released")


def test_a_missing_package_is_named_with_its_purpose_and_the_command(told, monkeypatch):
    monkeypatch.setattr(installation, "is_installed", lambda module: module != "casadi")
    lines = told().splitlines()
    [at] = [i for i, line in enumerate(lines) if "lacks casadi" in line]

    assert lines[at].split()[0] == "native"
    assert "native FMUs from sources" in lines[at]
    assert lines[at + 1].strip() == "pip install -e '.[native]'"
    assert sum("lacks" in line for line in lines) == 1


def test_a_requirement_that_is_gone_is_missing(told, monkeypatch):
    def version(name, known=importlib.metadata.version):
        if name == "lxml":
            raise importlib.metadata.PackageNotFoundError(name)
        return known(name)

    monkeypatch.setattr(importlib.metadata, "version", version)
    [line] = [line for line in told().splitlines() if line.split()[:1] == ["lxml"]]

    assert line.split() == ["lxml", "missing"]


def test_the_cache_has_its_size_and_can_be_cleared(told, cache):
    assert f"cache: {cache}, 2.0 MB" in told()

    assert json.loads(told("--clear-cache", "--json"))["cache"] == {
        "folder": str(cache),
        "writable": True,
        "bytes": 0,
    }
    assert not (cache / "built.fmu").exists()


def test_a_cache_that_cannot_be_written_is_said_with_the_way_out(told, cache, monkeypatch):
    monkeypatch.setenv("DOCKLOOP_CACHE", str(cache / "built.fmu"))  # a file
    text = told()

    assert f"cache: {cache / 'built.fmu'} cannot be written" in text
    assert "DOCKLOOP_CACHE names another folder" in text

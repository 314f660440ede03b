import json
import os

import pytest

from fmu_sources.composed.registry import load, modules
from fmu_sources.export.native_flavour import source_stamp
from fmu_sources.export.stamp_cache import StampCache


@pytest.fixture
def sources(tmp_path):
    folder = tmp_path / "sources"
    (folder / "deeper").mkdir(parents=True)
    (folder / "deeper" / "a.py").write_text("a = 1\n", encoding="utf-8")
    return folder


def stamp_of(tmp_path, sources, computed):
    return StampCache(tmp_path / "kept" / "STAMPS.json", sources).stamp("m", lambda: computed)


def test_a_stamp_is_kept_while_no_source_changes(tmp_path, sources):
    assert stamp_of(tmp_path, sources, "first") == "first"
    assert stamp_of(tmp_path, sources, "second") == "first"


def test_a_source_that_keeps_its_size_and_time_but_not_its_content_changes_the_stamp(tmp_path, sources):
    stamp_of(tmp_path, sources, "first")
    file = sources / "deeper" / "a.py"
    before = file.stat()
    file.write_text("a = 2\n", encoding="utf-8")
    os.utime(file, ns=(before.st_atime_ns, before.st_mtime_ns))
    assert stamp_of(tmp_path, sources, "second") == "second"


def test_a_new_source_and_one_that_is_gone_change_the_stamp(tmp_path, sources):
    stamp_of(tmp_path, sources, "first")
    (sources / "b.py").touch()
    assert stamp_of(tmp_path, sources, "second") == "second"
    (sources / "deeper" / "a.py").unlink()
    assert stamp_of(tmp_path, sources, "third") == "third"


def test_byte_code_is_no_source(tmp_path, sources):
    stamp_of(tmp_path, sources, "first")
    (sources / "__pycache__").mkdir()
    (sources / "__pycache__" / "a.pyc").touch()
    assert stamp_of(tmp_path, sources, "second") == "first"


@pytest.mark.parametrize("content", ["", "[]", "{}", '{"sources": 1}', "\0"])
def test_a_damaged_file_of_stamps_counts_as_none(tmp_path, sources, content):
    stamp_of(tmp_path, sources, "first")
    (tmp_path / "kept" / "STAMPS.json").write_text(content, encoding="utf-8")
    assert stamp_of(tmp_path, sources, "second") == "second"
    assert json.loads((tmp_path / "kept" / "STAMPS.json").read_bytes())["stamps"] == {"m": "second"}


def test_stamps_are_computed_where_none_can_be_kept(tmp_path, sources):
    (tmp_path / "kept").touch()  # a file where the folder would be
    assert stamp_of(tmp_path, sources, "first") == "first"
    assert stamp_of(tmp_path, sources, "second") == "second"


def test_the_cache_gives_the_stamp_of_a_model(tmp_path):
    name = "spacecraft"
    expected = source_stamp(load(name), *modules(name))
    file = tmp_path / "STAMPS.json"
    for _ in range(2):
        assert StampCache(file).stamp(name, lambda: source_stamp(load(name), *modules(name))) == expected

"""The writers of fmu_sources and of master put a file in its place whole, or leave what was there."""

from __future__ import annotations

import pytest

from fmu_sources.export import whole_file as exported
from master.recording import whole_file as recorded


def write_bytes(path, text):
    exported.write_whole(path, text.encode())


both = pytest.mark.parametrize("write", [write_bytes, recorded.write_whole])


@both
def test_a_file_is_written_into_a_new_folder_and_over_an_old_one(write, tmp_path):
    path = tmp_path / "a" / "b.txt"
    write(path, "first")
    write(path, "µ second\n")

    assert path.read_bytes() == "µ second\n".encode()
    assert [p.name for p in path.parent.iterdir()] == ["b.txt"]
    assert path.stat().st_mode & 0o777 == 0o644


@both
def test_what_was_there_stays_where_writing_fails(write, tmp_path, monkeypatch):
    path = tmp_path / "b.txt"
    write(path, "first")

    def full(self, content):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("pathlib.Path.write_bytes", full)
    with pytest.raises(OSError, match="No space left"):
        write(path, "second")

    assert path.read_text() == "first"
    assert [p.name for p in tmp_path.iterdir()] == ["b.txt"]

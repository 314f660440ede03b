import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pyarrow.parquet as parquet
import pytest

from master.recording import files as files_module
from master.recording.files import ResultFiles, read_csv
from master.recording.recorder import Result

N = 4000
VALUES = np.random.default_rng(5).normal(size=(N, 3))
VALUES[7, 1] = np.nan


def rows(begin, end):
    return Result(np.arange(begin, end) * 0.5, ("a.x", "a.y", "b.z"), ("m", "1", "N"), VALUES[begin:end])


@pytest.fixture
def at_once(monkeypatch):
    """Every block of rows is written at once, each as a part."""
    monkeypatch.setattr(files_module, "_BLOCK_SECONDS", 0.0)
    monkeypatch.setattr(files_module, "_PART_SECONDS", -1.0)
    monkeypatch.setattr(files_module, "_PART_SHARE", 0.0)


def values_of(path):
    table = parquet.read_table(path)
    return np.column_stack([table[name].to_numpy() for name in table.column_names[1:]])


def test_the_parts_of_a_run_that_goes_on_hold_every_row_written(tmp_path, at_once):
    files = ResultFiles(tmp_path)
    for k in range(0, 1000, 100):
        files.write(rows(k, k + 100))
    parts = sorted(tmp_path.glob("result.part-*.parquet"))

    assert np.array_equal(np.vstack([values_of(p) for p in parts]), VALUES[:1000], equal_nan=True)
    assert np.array_equal(read_csv(files.csv).values, VALUES[:1000], equal_nan=True)
    assert not files.parquet.exists()


def test_parts_become_one_file_with_units_at_the_end(tmp_path, at_once):
    with ResultFiles(tmp_path) as files:
        for k in range(0, N, 500):
            files.write(rows(k, k + 500))

    assert {path.name for path in tmp_path.iterdir()} == {"result.csv", "result.parquet"}
    assert np.array_equal(values_of(files.parquet), VALUES, equal_nan=True)
    assert parquet.read_schema(files.parquet).field("b.z").metadata == {b"unit": b"N"}


def test_rows_one_by_one_are_written_in_blocks(tmp_path):
    with ResultFiles(tmp_path) as files:
        for k in range(300):
            files.write(rows(k, k + 1))

    assert parquet.ParquetFile(files.parquet).num_row_groups < 30
    assert np.array_equal(values_of(files.parquet), VALUES[:300], equal_nan=True)


def test_a_folder_removed_in_a_run_is_told_and_all_rows_are_written_again(tmp_path, at_once):
    folder = tmp_path / "out"
    files = ResultFiles(folder)
    files.write(rows(0, 500))
    files.write(rows(500, 1000))
    shutil.rmtree(folder)
    with pytest.raises(OSError, match="removed during the run"):
        files.write(rows(1000, 1500))
    files.rescue()

    assert np.array_equal(read_csv(files.csv).values, VALUES[:1500], equal_nan=True)
    assert np.array_equal(values_of(files.parquet), VALUES[:1500], equal_nan=True)
    assert parquet.read_schema(files.parquet).field("a.x").metadata == {b"unit": b"m"}


FULL = """
import resource, sys, pathlib
sys.path[:0] = [{here!r}]
from test_interrupted_files import *
from master.recording.files import write_result
files_module._BLOCK_SECONDS, files_module._PART_SECONDS = 0.0, -1.0
resource.setrlimit(resource.RLIMIT_FSIZE, (100_000, 100_000))
folder = pathlib.Path({folder!r})
{action}
"""
STREAM = """
files = ResultFiles(folder)
try:
    for k in range(0, N, 100):
        files.write(rows(k, k + 100))
except OSError as error:
    print(error)
    files.rescue()
"""
AT_ONCE = """
try:
    write_result(rows(0, N), folder)
except OSError as error:
    print(error)
"""


@pytest.mark.parametrize("action", [STREAM, AT_ONCE])
def test_on_a_full_disk_whole_rows_stay_readable(tmp_path, action):
    """A limit on the size of files fails in the middle of a write, as a full disk does."""
    text = FULL.format(here=str(Path(__file__).parent), folder=str(tmp_path), action=action)
    done = subprocess.run([sys.executable, "-c", text], capture_output=True, text=True, check=True)
    found = read_csv(tmp_path / "result.csv").values
    kept = np.vstack([values_of(path) for path in sorted(tmp_path.glob("*.parquet"))])

    assert "File too large" in done.stdout
    assert (tmp_path / "result.csv").read_bytes().endswith(b"\n")
    assert len(found) >= 1000
    assert len(kept) >= 1000
    assert np.array_equal(found, VALUES[: len(found)], equal_nan=True)
    assert np.array_equal(kept, VALUES[: len(kept)], equal_nan=True)
    assert not list(tmp_path.glob(".*"))

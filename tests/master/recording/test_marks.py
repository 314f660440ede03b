"""Results go on from a mark: what was written after it is cut off, what is too short is refused."""

from __future__ import annotations

import numpy as np
import pyarrow.parquet as parquet
import pytest

from master.errors import DataError
from master.recording import files as files_module
from master.recording.files import FilesMark, ResultFiles, read_csv
from master.recording.recorder import Result

VALUES = np.random.default_rng(7).normal(size=(400, 2))


def rows(begin, end):
    return Result(np.arange(begin, end) * 0.5, ("a.x", "b.y"), ("m", "N"), VALUES[begin:end])


@pytest.fixture(params=[1, 40], ids=["row by row", "in blocks"])
def marked(request, tmp_path, monkeypatch):
    """Files of 200 rows, marked after 120, that nobody closed: their process was killed; folder and mark."""
    monkeypatch.setattr(files_module, "_BLOCK_SECONDS", 0.0)
    monkeypatch.setattr(files_module, "_PART_SECONDS", -1.0)
    monkeypatch.setattr(files_module, "_PART_SHARE", 0.0)
    files = ResultFiles(tmp_path)
    mark = None
    for k in range(0, 200, request.param):
        if k == 120:
            mark = files.mark()
        files.write(rows(k, k + request.param))
    files.mark()
    return tmp_path, mark


def test_a_mark_before_any_row_is_the_beginning(tmp_path):
    assert ResultFiles(tmp_path).mark() == FilesMark(0, 0)


def test_files_go_on_after_the_mark_as_if_nothing_had_happened(marked, tmp_path_factory):
    folder, mark = marked
    assert mark.n_rows == 120
    with ResultFiles(folder, mark=mark) as files:
        files.write(rows(120, 400))
    with ResultFiles(tmp_path_factory.mktemp("whole")) as whole:
        whole.write(rows(0, 400))
    table = parquet.read_table(files.parquet)

    assert files.csv.read_bytes() == whole.csv.read_bytes()
    assert np.array_equal(read_csv(files.csv).values, VALUES)
    assert np.array_equal(np.column_stack([table["a.x"].to_numpy(), table["b.y"].to_numpy()]), VALUES)
    assert parquet.read_schema(files.parquet).field("b.y").metadata == {b"unit": b"N"}
    assert {path.name for path in folder.iterdir()} == {"result.csv", "result.parquet"}


def test_files_that_were_closed_go_on_too(marked):
    folder, mark = marked
    with ResultFiles(folder, mark=mark) as files:
        files.write(rows(120, 200))
    with ResultFiles(folder, mark=mark) as again:
        again.write(rows(120, 400))

    assert np.array_equal(read_csv(again.csv).values, VALUES)
    assert parquet.read_table(again.parquet).num_rows == 400


def test_a_csv_file_that_is_too_short_is_refused(marked):
    folder, mark = marked
    (folder / "result.csv").write_bytes(b'"time"\n')

    with pytest.raises(
        DataError, match=rf"result\.csv: is too short, got 7 bytes, expected {mark.csv_bytes}"
    ):
        ResultFiles(folder, mark=mark)


def test_parts_that_are_gone_are_refused(marked):
    folder, mark = marked
    first, *_ = sorted(folder.glob("result.part-*.parquet"))
    n = parquet.read_metadata(first).num_rows
    first.unlink()

    with pytest.raises(DataError, match=r"parts of result\.parquet: got \d+ rows, expected "):
        ResultFiles(folder, mark=FilesMark(201 - n, mark.csv_bytes))


def test_files_that_are_gone_are_refused(tmp_path):
    with pytest.raises(DataError, match=r"expected 5|cannot be continued"):
        ResultFiles(tmp_path, mark=FilesMark(5, 100))

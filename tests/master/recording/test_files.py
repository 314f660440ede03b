import os
import subprocess
import sys

import numpy as np
import pytest
from fmpy.util import read_csv as fmpy_read_csv
from pyarrow import parquet

from master.recording.files import ResultFiles, read_csv, write_result
from master.recording.recorder import Result
from tests.conftest import PROJECT


@pytest.fixture
def result():
    """Values that need all 17 digits."""
    values = np.array([[1.0 / 3.0, -1e-300], [np.pi, 6.02e23], [0.1 + 0.2, 0.0]])
    return Result(np.array([0.0, 0.1, 0.2]), ("mass.x", "rope.f"), ("m", "N"), values)


def test_a_csv_reads_back_to_the_last_bit(result, tmp_path):
    back = read_csv(write_result(result, tmp_path).csv)

    assert back.names == result.names
    assert np.array_equal(back.time, result.time)
    assert np.array_equal(back.values, result.values)


def test_fmpy_reads_the_csv(result, tmp_path):
    table = fmpy_read_csv(str(write_result(result, tmp_path).csv))

    assert table.dtype.names == ("time", "mass.x", "rope.f")
    assert table["time"].tolist() == result.time.tolist()
    assert table["rope.f"].tolist() == result["rope.f"].tolist()


def test_the_csv_begins_with_quoted_names(result, tmp_path):
    text = write_result(result, tmp_path).csv.read_text(encoding="utf-8")

    assert text.splitlines()[0] == '"time","mass.x","rope.f"'
    assert len(text.splitlines()) == 4


def test_a_result_without_signals_has_its_times(tmp_path):
    empty = Result(np.array([0.0, 0.5]), (), (), np.empty((2, 0)))
    back = read_csv(write_result(empty, tmp_path).csv)

    assert (back.time.tolist(), back.names, back.values.shape) == ([0.0, 0.5], (), (2, 0))


def test_parquet_has_a_unit_for_every_column(result, tmp_path):
    table = parquet.read_table(write_result(result, tmp_path).parquet)

    assert {f.name: f.metadata[b"unit"] for f in table.schema} == {
        "time": b"s",
        "mass.x": b"m",
        "rope.f": b"N",
    }
    assert np.array_equal(table["mass.x"].to_numpy(), result["mass.x"])


def test_rows_written_one_after_the_other_are_the_rows_written_at_once(result, tmp_path):
    with ResultFiles(tmp_path / "rows") as files:
        for k in range(3):
            files.write(Result(result.time[k : k + 1], result.names, result.units, result.values[k : k + 1]))
    whole = write_result(result, tmp_path / "whole")

    assert files.csv.read_bytes() == whole.csv.read_bytes()
    assert parquet.read_table(files.parquet) == parquet.read_table(whole.parquet)


def test_results_are_written_without_pandas(tmp_path):
    code = (
        "import sys; from pathlib import Path; import numpy as np\n"
        "from master.recording.files import write_result\n"
        "from master.recording.recorder import Result\n"
        "write_result(Result(np.arange(3.0), ('a.b',), ('m',), np.ones((3, 1))), Path('out'))\n"
        "print('pandas' in sys.modules)"
    )
    environment = {**os.environ, "PYTHONPATH": str(PROJECT)}
    done = subprocess.run(
        [sys.executable, "-c", code],
        cwd=tmp_path,
        env=environment,
        capture_output=True,
        text=True,
        check=True,
    )

    assert done.stdout == "False\n"

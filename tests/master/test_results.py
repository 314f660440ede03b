import numpy as np
import pytest
from fmpy.util import read_csv as fmpy_read_csv
from pyarrow import parquet

from master.recorder import Result
from master.results import read_csv, write_csv, write_parquet


@pytest.fixture
def result():
    """Values that need all 17 digits."""
    values = np.array([[1.0 / 3.0, -1e-300], [np.pi, 6.02e23], [0.1 + 0.2, 0.0]])
    return Result(np.array([0.0, 0.1, 0.2]), ("mass.x", "rope.f"), ("m", "N"), values)


def test_a_csv_reads_back_to_the_last_bit(result, tmp_path):
    back = read_csv(write_csv(result, tmp_path / "result.csv"))

    assert back.names == result.names
    assert np.array_equal(back.time, result.time)
    assert np.array_equal(back.values, result.values)


def test_fmpy_reads_the_csv(result, tmp_path):
    table = fmpy_read_csv(str(write_csv(result, tmp_path / "result.csv")))

    assert table.dtype.names == ("time", "mass.x", "rope.f")
    assert table["time"].tolist() == result.time.tolist()
    assert table["rope.f"].tolist() == result["rope.f"].tolist()


def test_the_csv_begins_with_quoted_names(result, tmp_path):
    text = write_csv(result, tmp_path / "result.csv").read_text(encoding="utf-8")

    assert text.splitlines()[0] == '"time","mass.x","rope.f"'
    assert len(text.splitlines()) == 4


def test_a_result_without_signals_has_its_times(tmp_path):
    empty = Result(np.array([0.0, 0.5]), (), (), np.empty((2, 0)))
    back = read_csv(write_csv(empty, tmp_path / "result.csv"))

    assert (back.time.tolist(), back.names, back.values.shape) == ([0.0, 0.5], (), (2, 0))


def test_parquet_has_a_unit_for_every_column(result, tmp_path):
    table = parquet.read_table(write_parquet(result, tmp_path / "result.parquet"))

    assert {f.name: f.metadata[b"unit"] for f in table.schema} == {
        "time": b"s",
        "mass.x": b"m",
        "rope.f": b"N",
    }
    assert np.array_equal(table["mass.x"].to_numpy(), result["mass.x"])

"""What the process that reads MAT files makes of their structures; here in this process."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.io import savemat

from master.recording.mat_reader import _contents


@pytest.fixture
def contents(tmp_path):
    def read(**arrays):
        savemat(tmp_path / "file.mat", arrays)
        return _contents(str(tmp_path / "file.mat"))

    return read


def test_arrays_have_their_names_and_the_header_is_no_array(contents):
    found = contents(t=np.arange(4.0), q=np.ones((2, 3)))

    assert set(found) == {"t", "q"}
    assert np.ravel(found["t"]).tolist() == [0.0, 1.0, 2.0, 3.0]
    assert found["q"].shape == (2, 3)


def test_fields_of_nested_structures_have_names_with_points(contents):
    found = contents(log={"time": np.arange(3.0), "rig": {"force": np.array([5.0, 6.0, 7.0])}})

    assert set(found) == {"log.time", "log.rig.force"}
    assert np.ravel(found["log.rig.force"]).tolist() == [5.0, 6.0, 7.0]


def test_a_row_of_structures_is_a_column_of_each_number_and_words_are_left_out(contents):
    row = np.zeros(3, dtype=[("f", "f8"), ("said", "O")])
    row["f"] = [1.0, 2.0, 4.0]
    row["said"] = ["a", "b", "c"]
    found = contents(samples=row)

    assert set(found) == {"samples.f"}
    assert found["samples.f"].tolist() == [1.0, 2.0, 4.0]


def test_a_damaged_file_is_told_in_one_line(tmp_path):
    path = tmp_path / "file.mat"
    savemat(path, {"t": np.arange(1000.0)})
    path.write_bytes(path.read_bytes()[:300])
    said = _contents(str(path))

    assert isinstance(said, str)
    assert ": " in said
    assert "\n" not in said

import numpy as np
import pytest

from master.recording.files import ResultFiles, read_csv, write_result
from master.recording.recorder import Recorder
from tests.stubs import ERROR, bench, clock, failing, integrator, wire


def made():
    wires = [wire("a.x", "b.u"), wire("b.x", "a.u")]
    return bench(
        {"a": integrator(), "b": integrator()}, wires, ["a", "b"], step_size=0.1, start={"a": {"x": 1.0}}
    )


def test_streamed_files_are_those_written_at_the_end(tmp_path):
    with ResultFiles(tmp_path / "streamed") as files:
        made().run(1000, sink=files)
    whole = write_result(made().run(1000).result, tmp_path / "whole")

    assert files.csv.read_bytes() == whole.csv.read_bytes()


@pytest.mark.parametrize("keep_every", [2, 7, 64, 5000])
def test_memory_keeps_every_nth_row_of_a_streamed_run(tmp_path, keep_every):
    with ResultFiles(tmp_path) as files:
        kept = made().run(1000, sink=files, keep_every=keep_every).result
    whole = made().run(1000).result

    assert np.array_equal(kept.values, whole.values[::keep_every])
    assert np.array_equal(kept.time, whole.time[::keep_every])
    assert np.array_equal(read_csv(files.csv).values, whole.values)


def test_what_a_run_computed_before_it_failed_is_on_disk(tmp_path):
    system = bench({"c": clock(), "bad": failing(5.0, ERROR)})
    with ResultFiles(tmp_path) as files:
        system.run(100, sink=files)

    assert read_csv(files.csv)["c.t"].tolist() == [0.0, 1.0, 2.0, 3.0, 4.0, 5.0]


def test_a_table_that_grows_loses_no_row(monkeypatch):
    monkeypatch.setattr("master.recording.recorder._FIRST_BYTES", 8000)
    system = bench({"a": clock()}).system
    recorder = Recorder([system.port("a.t")], 0.0, 1.0, most_rows=10**6)
    for first in range(0, 200_000, 1000):
        room = recorder.room(1000)
        room[:, 0] = np.arange(first, first + 1000)
        recorder.add(room)

    assert np.array_equal(recorder.result()["a.t"], np.arange(200_000.0))


def test_rows_of_a_chunk_that_ended_early_are_followed_by_the_next(tmp_path):
    system = bench({"a": clock()}).system
    recorder = Recorder([system.port("a.t")], 0.0, 1.0, most_rows=10)
    room = recorder.room(4)
    room[:, 0] = [1.0, 2.0, 3.0, 4.0]
    recorder.add(room[:2])
    recorder.add(np.array([[9.0]]))

    assert recorder.result()["a.t"].tolist() == [1.0, 2.0, 9.0]

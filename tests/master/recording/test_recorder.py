import numpy as np
import pytest

from master.recording.recorder import Recorder
from tests.stubs import METRE, NEWTON, bench, gain


@pytest.fixture
def recorder():
    system = bench({"a": gain(source=METRE), "b": gain(source=NEWTON)}).system
    return Recorder([system.port("a.y"), system.port("b.y")], t0=2.0, step_size=0.5)


def test_chunks_join_in_their_order(recorder):
    recorder.add(np.array([[1.0, 10.0]]))
    recorder.add(np.array([[2.0, 20.0], [3.0, 30.0]]))
    result = recorder.result()

    assert result.time.tolist() == [2.0, 2.5, 3.0]
    assert result["b.y"].tolist() == [10.0, 20.0, 30.0]


def test_a_chunk_is_copied(recorder):
    rows = np.array([[1.0, 10.0]])
    recorder.add(rows)
    rows[:] = 0.0

    assert recorder.result()["a.y"].tolist() == [1.0]


def test_a_result_knows_the_units(recorder):
    recorder.add(np.zeros((1, 2)))
    result = recorder.result()

    assert (result.names, result.units) == (("a.y", "b.y"), ("m", "N"))
    assert result.unit("b.y") == "N"


def test_a_signal_that_was_not_recorded_is_a_key_error(recorder):
    recorder.add(np.zeros((1, 2)))

    with pytest.raises(KeyError, match=r"c\.y"):
        recorder.result()["c.y"]

"""Rows on their way from one process to another."""

from __future__ import annotations

import mmap
import sys

import numpy as np
import pytest

from master.process.memory import shared_memory
from master.process.position import N_BYTES, Position
from master.recording.shared_rows import SharedRows

N_SIGNALS = 100
N_ROWS = 20_000


def test_rows_are_taken_a_few_megabytes_at_a_time_whole_and_in_order():
    rows = SharedRows(Position(shared_memory(N_BYTES)), N_SIGNALS, N_ROWS, is_ring=True)
    values = np.arange(N_ROWS * N_SIGNALS, dtype=float).reshape(N_ROWS, N_SIGNALS)
    rows.add(values)
    taken = []
    while len(some := rows.take(N_ROWS)):
        taken.append(some)

    assert len(taken) > 1
    assert max(some.nbytes for some in taken) <= 2**22
    assert np.array_equal(np.concatenate(taken), values)


def test_a_row_wider_than_that_is_taken_alone():
    n_signals = 2**20
    rows = SharedRows(Position(shared_memory(N_BYTES)), n_signals, 3, is_ring=True)
    rows.add(np.ones((3, n_signals)))

    assert [len(rows.take(3)) for _ in range(4)] == [1, 1, 1, 0]


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="counts pages as /proc of Linux shows them")
def test_a_ring_has_all_its_pages_before_rows_come():
    rows = SharedRows(Position(shared_memory(N_BYTES)), N_SIGNALS, 10**7, is_ring=True)
    before = shared_megabytes()

    rows.touch()
    touched = shared_megabytes()
    rows.room(rows.capacity)[:] = 1.0

    assert touched - before == pytest.approx(rows.capacity * N_SIGNALS * 8 / 2**20, abs=1.0)
    assert shared_megabytes() == pytest.approx(touched, abs=1.0)


def shared_megabytes():
    with open("/proc/self/statm") as file:
        return int(file.read().split()[2]) * mmap.PAGESIZE / 2**20

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


@pytest.mark.parametrize(("n_signals", "most"), [(4, 2**18), (100, 2**18), (2000, 2**21)])
def test_rows_are_taken_a_small_piece_at_a_time_whole_and_in_order(n_signals, most):
    n_rows = 2**21 // n_signals
    rows = SharedRows(Position(shared_memory(N_BYTES)), n_signals, n_rows, is_ring=True)
    values = np.arange(n_rows * n_signals, dtype=float).reshape(n_rows, n_signals)
    rows.add(values)
    taken = []
    while len(some := rows.take(n_rows)):
        taken.append(some)

    assert len(taken) > 1
    assert max(some.nbytes for some in taken) <= most
    assert np.array_equal(np.concatenate(taken), values)


def test_a_row_of_megabytes_is_taken_alone():
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

"""Short soaks; longer ones: `python -m tests.reliability.soak`."""

from __future__ import annotations

import sys

import pytest

from tests.reliability.soak import MOST_BYTES, soak

pytestmark = pytest.mark.skipif(not sys.platform.startswith("linux"), reason="looks into /proc")


@pytest.mark.long
@pytest.mark.parametrize(("kind", "number"), [("systems", 20), ("apart", 3)])
def test_systems_one_after_the_other_leave_no_handle_thread_process_or_folder(kind, number):
    soaked = soak(kind, number)

    assert soaked.first.files == soaked.last.files
    assert soaked.first.threads == soaked.last.threads
    assert soaked.first.processes == soaked.last.processes
    assert soaked.first.folders == soaked.last.folders


@pytest.mark.long
def test_a_run_that_says_something_else_in_each_step_writes_bounded_files():
    soaked = soak("messages", 200_000)

    assert 0 < soaked.largest_file < MOST_BYTES
    assert soaked.first.files == soaked.last.files
    assert soaked.last.memory < soaked.first.memory + 40.0  # the ring of rows is filled meanwhile

"""Results are never half, whichever write, rename or fsync fails; all of them: `python -m` the harness."""

from __future__ import annotations

import shutil
import sys

import pytest

from tests.reliability.faults_in_files import preloaded

pytestmark = pytest.mark.skipif(
    not sys.platform.startswith("linux") or shutil.which("cc") is None, reason="needs a preloaded library"
)


@pytest.mark.long
def test_a_fault_at_any_call_leaves_files_that_open_and_go_on_with_the_same_bytes(tmp_path):
    """Every 9th call here, in five kinds of faults."""
    done = preloaded(tmp_path, "9")

    assert done.stdout.splitlines()[-1].endswith(" faults, 0 problems"), done.stdout + done.stderr
    assert int(done.stdout.split()[0]) > 30
    assert done.returncode == 0

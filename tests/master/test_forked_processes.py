"""How a process that calls FMUs ends."""

import subprocess
import sys

import pytest

pytestmark = pytest.mark.skipif(
    not sys.platform.startswith("linux"), reason="FMUs are called in forked processes on Linux alone"
)

CHILD_THAT_EXITS = """
import ctypes, os
from master.errors import FmuError
from master.process.child import done_apart

c = ctypes.CDLL(None)
c.__cxa_atexit(c.abort, None, None)  # as a library does that joins threads which a child has not

def work():
    c.printf(b"the last words\\n")
    c.exit(5)

try:
    done_apart(work)
except FmuError as error:
    print(error, flush=True)
os._exit(0)
"""


def test_a_process_that_an_fmu_exits_runs_no_handlers_of_its_parent_and_flushes_what_was_printed():
    done = subprocess.run(
        [sys.executable, "-c", CHILD_THAT_EXITS], capture_output=True, text=True, check=True
    )

    assert "ended the process, exit status 5, in no call of an FMU" in done.stdout
    assert "the last words" in done.stderr

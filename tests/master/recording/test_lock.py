"""A file that one process holds, and what becomes of it when that process is killed."""

import subprocess
import sys

import pytest

from master.recording.lock import FileLock, Held

HOLDER = """
import os, sys, time
from pathlib import Path
from master.recording.lock import FileLock

lock = FileLock(Path(sys.argv[1]))
lock.fill(64)
if os.fork() == 0:
    os.close(1)
    time.sleep(float(sys.argv[2]))
os._exit(0)
"""


@pytest.mark.skipif(sys.platform == "win32", reason="on Windows no child inherits the lock")
def test_a_file_is_taken_once_the_children_of_a_process_that_ended_have_ended_too(tmp_path):
    path = tmp_path / "lock"
    subprocess.run([sys.executable, "-c", HOLDER, str(path), "0.5"], check=True, stdout=subprocess.PIPE)

    FileLock(path).release()


def test_a_file_that_a_living_process_holds_is_refused_without_a_wait(tmp_path, monkeypatch):
    path = tmp_path / "lock"
    lock = FileLock(path)
    lock.fill(64)
    monkeypatch.setattr("master.recording.lock.time.sleep", lambda _: pytest.fail("it waited"))
    with pytest.raises(Held):
        FileLock(path)
    lock.release()

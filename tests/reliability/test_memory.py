"""Too little memory is said in words."""

from __future__ import annotations

import ctypes
import errno
import faulthandler
import json
import os
import resource
import signal
import subprocess
import sys

import click
import pytest

from master.cli.common import JSON, answers_errors
from master.errors import FmuError, MasterError
from master.process import memory
from master.process.child import done_apart
from master.process.mailbox import Mailbox
from master.process.memory import is_of_memory, require_room_for_libraries, room, shared_memory
from master.process.workers import each_needed, workers
from master.reproduce.measures import pool
from master.reproduce.measures.runs import Run, Wanted
from tests.reliability.address_space import COMMANDS, ending


def test_address_space_that_the_system_does_not_give_is_named():
    with pytest.raises(MasterError, match=r"memory: the run has too little, got .* for 4398046511104 MB"):
        shared_memory(2**62)


def test_a_command_that_runs_out_of_memory_says_so_and_has_the_status_of_a_wrong_input(capsys):
    @click.command()
    @JSON
    @answers_errors
    def command(as_json):
        raise MemoryError

    with pytest.raises(SystemExit) as end:
        command(["--json"])
    said = capsys.readouterr()

    assert end.value.code == 2
    assert said.err.startswith("memory: there is too little, expected more address space")
    assert json.loads(said.out)["status"] == "failed"


def limited(n_bytes):
    """Let the address space of this process, a forked one, end `n_bytes` after what it has."""
    with open("/proc/self/statm") as file:
        has = int(file.read().split()[0]) * os.sysconf("SC_PAGE_SIZE")
    resource.setrlimit(resource.RLIMIT_AS, (has + n_bytes, resource.RLIM_INFINITY))
    return has + n_bytes


def test_what_may_stay_unused_takes_a_small_part_of_an_address_space_that_is_limited():
    def work():
        limit = limited(2**30)
        return limit, room(2**40), room(2**10), Mailbox().most_bytes

    limit, large, small, mailbox = done_apart(work)

    assert room(2**40) == 2**40
    assert large == limit // 32
    assert small == 2**10
    assert mailbox == min(2**28, limit // 32)


def test_a_result_that_has_no_room_is_named():
    def work():
        limited(2**30)
        mailbox = Mailbox()
        with pytest.raises(MasterError, match=r"memory: a result needs too much, got \d+ MB of \d+ MB"):
            mailbox.put(bytes(mailbox.most_bytes))
        mailbox.put("a small one")
        return mailbox.get()

    assert done_apart(work) == "a small one"


def test_libraries_that_have_no_room_are_refused_before_they_end_the_process():
    def work():
        limited(2**28)
        with pytest.raises(MasterError, match=r"memory: the run has too little, got .* for 384 MB"):
            require_room_for_libraries()
        return True

    assert done_apart(work)


ALGEBRA_WITHOUT_ROOM = """
import mmap, os, resource
from master.process.memory import take_room_of_linear_algebra

resource.setrlimit(resource.RLIMIT_AS, (2**31, 2**31))
take_room_of_linear_algebra()
import numpy as np
from scipy import linalg

a = np.random.default_rng(1).normal(size=(300, 300))
with open("/proc/self/statm") as file:
    left = 2**31 - int(file.read().split()[0]) * os.sysconf("SC_PAGE_SIZE")
taken = mmap.mmap(-1, left - 20 * 2**20)
print(np.linalg.norm(linalg.qr(a)[0]), np.linalg.norm(a @ a[0]) > 0)
"""


@pytest.mark.long
def test_linear_algebra_that_has_taken_its_buffers_needs_no_more_room():
    environment = os.environ | {"OPENBLAS_NUM_THREADS": "1"}
    words = [sys.executable, "-c", ALGEBRA_WITHOUT_ROOM]
    done = subprocess.run(words, env=environment, capture_output=True, text=True, timeout=200, check=True)

    norm, has_product = done.stdout.split()
    assert float(norm) == pytest.approx(300**0.5)
    assert has_product == "True"


def end_as_linear_algebra_does():
    ctypes.CDLL(None).exit(1)


def test_a_process_that_a_library_ends_where_memory_is_limited_has_the_words_of_too_little(monkeypatch):
    monkeypatch.setattr(memory, "address_space", lambda: 2.0**31)

    said = (
        r"memory: the command ended the process, exit status 1, .* got an address space of 2048 MB, expected"
    )
    with pytest.raises(MasterError, match=said) as caught:
        done_apart(end_as_linear_algebra_does)

    assert caught.value.exit_status == 2


@pytest.mark.parametrize("number", [signal.SIGSEGV, signal.SIGBUS, signal.SIGFPE])
def test_a_crash_is_no_lack_of_memory_where_memory_is_limited(number, monkeypatch):
    monkeypatch.setattr(memory, "address_space", lambda: 2.0**31)

    def crash():
        faulthandler.disable()
        os.kill(os.getpid(), number)

    with pytest.raises(FmuError, match=f"ended the process, killed by {number.name}"):
        done_apart(crash)


THIS_PROCESS = os.getpid()


def runs_where_no_worker_bears_them(wishes):
    """End a worker, as an FMU may; in the process that began it, make the runs."""
    if os.getpid() != THIS_PROCESS:
        os._exit(1)
    return {run: run.config for run in wishes}


def test_runs_that_end_a_worker_are_made_one_by_one_where_memory_is_limited_too(monkeypatch):
    monkeypatch.setattr(memory, "address_space", lambda: 2.0**31)
    monkeypatch.setattr(pool, "workers", lambda n, method: workers(n, "fork"))
    monkeypatch.setattr(pool, "perform_part", runs_where_no_worker_bears_them)
    monkeypatch.setattr(pool, "CHUNK", 1)

    found = pool.perform_all({Run("a"): Wanted(), Run("b"): Wanted()}, lambda n: None, processes=2)

    assert found == {Run("a"): "a", Run("b"): "b"}


def test_a_worker_that_a_library_ends_is_no_wait_for_ever_but_words(monkeypatch):
    monkeypatch.setattr(memory, "address_space", lambda: 2.0**31)

    with (
        pytest.raises(
            MasterError, match=r"memory: a process that works for the command ended, got .* 2048 MB"
        ),
        each_needed(),
        workers(1, "fork") as one,
    ):
        one.submit(end_as_linear_algebra_does).result()


def test_workers_without_room_are_refused_before_they_start():
    def work():
        limited(2**28)
        with (
            pytest.raises(MasterError, match=r"memory: the run has too little, got .* for 384 MB"),
            workers(1, "fork"),
        ):
            pass
        return True

    assert done_apart(work)


@pytest.mark.parametrize(
    ("error", "is_so"),
    [
        (MemoryError(), True),
        (OSError(errno.ENOMEM, "Cannot allocate memory"), True),
        (ImportError("libarrow.so: failed to map segment from shared object"), True),
        (RuntimeError("can't start new thread"), True),
        (SystemError("error return without exception set"), True),
        (ImportError("No module named 'h5py'"), False),
        (OSError(errno.ENOSPC, "No space left on device"), False),
        (ValueError("cannot allocate memory"), False),
    ],
)
def test_what_a_library_says_without_memory_is_told_from_its_other_faults(error, is_so):
    def work():
        limited(2**30)
        outer = RuntimeError("could not load")
        outer.__cause__ = error
        return is_of_memory(error), is_of_memory(outer)

    assert done_apart(work) == (is_so, is_so)


def test_a_library_that_is_missing_is_no_lack_of_memory_where_nothing_is_limited():
    assert not is_of_memory(ImportError("a.so: failed to map segment from shared object"))


@pytest.mark.long
@pytest.mark.parametrize(("command", "megabytes"), [("run", 600), ("isolate", 1400), ("check", 300)])
def test_a_command_with_little_address_space_works_or_says_so(command, megabytes):
    end = ending(COMMANDS[command], megabytes, 500.0)

    assert end.fault() == "", end.said
    assert end.status == (2 if command == "run" else 0)

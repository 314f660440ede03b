"""
A process forked from this one, in which FMUs are called.

Whatever an FMU does to its process (a crash, `exit`, standard output, the working folder, umask, signals)
does not reach this one. Where the system cannot fork, all is done in this process.
"""

from __future__ import annotations

import ctypes
import os
import pickle
import select
import signal
import sys
import tempfile
import time
import traceback
import warnings
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from typing import Any, TypeVar, cast

from master.errors import FmuError

from . import memory, position
from .mailbox import Mailbox
from .memory import shared_memory
from .position import Position
from .surroundings import standard_output_as_error

T = TypeVar("T")

IS_POSSIBLE = sys.platform.startswith("linux")

_LOOK_SECONDS = 0.05
_PATIENCE_SECONDS = 2.0
_DEATH_SIGNAL = 1  # PR_SET_PDEATHSIG

_is_child = False
_last_work: list[Callable[[], Any]] | None = None  # where such work is put off


@dataclass(frozen=True)
class Answer:
    """What a child hands over: the result of its work, or the error that it ended with."""

    result: Any = None
    error: Exception | None = None


class Child:
    """
    A child process; `position` says which FMU it calls.

    Its temporary files are in a folder that is removed with it.
    """

    def __init__(self) -> None:
        self.position = Position(shared_memory(position.N_BYTES))
        self.mailbox = Mailbox()
        self._folder = tempfile.TemporaryDirectory(prefix="dockloop-", ignore_cleanup_errors=True)
        self._process = 0
        self._handle = -1
        self._status: int | None = None

    def begin(self, work: Callable[[], Any]) -> None:
        """Fork and let the child do some work; its result, or error, is in the mailbox then."""
        memory.require_room_for_libraries()
        sys.stdout.flush()
        sys.stderr.flush()
        parent = os.getpid()
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", DeprecationWarning)  # threads of numeric libraries, at rest
            self._process = os.fork()
        if self._process == 0:
            status = 1
            try:
                status = self._do(work, parent)
            except Exception:
                traceback.print_exc()  # a fault of this program: errors of the work are handed over
            finally:
                os._exit(status)
        self._handle = os.pidfd_open(self._process)

    def has_ended(self) -> bool:
        """Whether it has ended; waits a moment for that."""
        select.select([self._handle], [], [], _LOOK_SECONDS)
        ended, status = os.waitpid(self._process, os.WNOHANG)
        if ended:
            self._status = status
        return bool(ended)

    def ask_to_end(self) -> None:
        """Send it SIGTERM and wait for a while."""
        os.kill(self._process, signal.SIGTERM)
        until = time.monotonic() + _PATIENCE_SECONDS
        while not self.has_ended() and time.monotonic() < until:
            pass

    def kill(self) -> None:
        """End it at once."""
        os.kill(self._process, signal.SIGKILL)

    def is_complete(self) -> bool:
        """Whether it came to the end of its work."""
        return bool(self.position.cells[position.FINISHED])

    def exit_status(self) -> int:
        """Return the exit status that it ended with; 1 after a signal."""
        status = self._status or 0
        return os.WEXITSTATUS(status) if os.WIFEXITED(status) else 1

    def ended_by(self) -> int | None:
        """Return the number of the signal that ended it, None without one."""
        status = self._status or 0
        return os.WTERMSIG(status) if os.WIFSIGNALED(status) else None

    def ending(self) -> str:
        """Say how it ended, and in which call of an FMU."""
        call = self.position.call()
        within = f"in {call.function}" if call else "in no call of an FMU"
        return f"ended the process, {ending_of(self._status or 0)}, {within}"

    def close(self) -> None:
        """End it if it is still there, and remove its temporary files."""
        if self._process and self._status is None:
            self.kill()
            _, self._status = os.waitpid(self._process, 0)
        if self._handle >= 0:
            os.close(self._handle)
            self._handle = -1
        self._folder.cleanup()

    def _do(self, work: Callable[[], Any], parent: int) -> int:
        """In the child: do the work and hand over what it gives; return the exit status."""
        global _is_child
        _is_child = True
        die_with(parent)
        leave_at_exit()
        memory.share_no_further()
        tempfile.tempdir = os.environ["TMPDIR"] = self._folder.name
        status = 0
        with standard_output_as_error(), position.using(self.position):
            try:
                self.mailbox.put(Answer(result=work()))
            except SystemExit as end:  # a signal
                status = end.code if isinstance(end.code, int) else 1
            except Exception as error:
                self.mailbox.put(Answer(error=_portable(error)))
            self.position.cells[position.FINISHED] = 1.0
            for last in _last_work or ():
                last()
        return status


def put_off_last_work() -> list[Callable[[], Any]]:
    """In a child: put off what `do_last` is given until the result is handed over; return the list of it."""
    global _last_work
    _last_work = []
    return _last_work


def do_last(work: Callable[[], Any]) -> None:
    """Do some work now, or where it is put off, when its failure cannot harm any more."""
    if _last_work is None:
        work()
    else:
        _last_work.append(work)


def is_child() -> bool:
    """Whether this process was forked to call FMUs, and ends with that."""
    return _is_child


def done_apart(work: Callable[[], T]) -> T:
    """
    Do some work that calls FMUs, in a child process, and return its result, which can be pickled.

    Within such work, and where the system cannot fork, it is done in this process.

    Raises:
        FmuError: If an FMU ends the process; all that the work itself raises, too.
    """
    if _is_child or not IS_POSSIBLE:
        with standard_output_as_error():
            return work()
    child = Child()
    try:
        child.begin(work)
        try:
            while not child.has_ended():
                pass
        except BaseException:
            child.ask_to_end()
            if not child.is_complete():
                _raise_if_stuck(child)
            raise
        return cast("T", _result(child))
    finally:
        child.close()


def _result(child: Child) -> Any:
    answer = child.mailbox.get()
    if isinstance(answer, Answer) and answer.error is not None:
        raise answer.error
    if not child.is_complete():
        call = child.position.call()
        if call is None and child.ended_by() not in _of_other_causes():
            memory.raise_if_limited(f"the command {child.ending()}")
        where = call.instance if call else "the command"
        raise FmuError(where, child.ending(), time=child.position.time() if call else None, status="fatal")
    if not isinstance(answer, Answer):
        sys.exit(child.exit_status())
    return answer.result


def _of_other_causes() -> tuple[signal.Signals, ...]:
    """Signals that a lack of memory does not send: of whoever ends a process, and of faulty code."""
    return (signal.SIGKILL, signal.SIGTERM, signal.SIGSEGV, signal.SIGBUS, signal.SIGFPE)


def _raise_if_stuck(child: Child) -> None:
    call = child.position.call()
    if call is not None:
        said = f"did not return from {call.function}"
        raise FmuError(call.instance, said, time=child.position.time()) from None


def die_with(parent: int) -> None:
    """Let this process end with its parent, however that ends."""
    with suppress(OSError, AttributeError):
        ctypes.CDLL(None).prctl(_DEATH_SIGNAL, signal.SIGKILL)
    if os.getppid() != parent:
        os._exit(0)


def leave_at_exit() -> None:
    """
    Let an FMU that calls `exit` end this process with its status, as if it had been alone here.

    The parent's libraries have registered handlers too (thread pools that join their threads), and their
    threads are not in this process: they are not run. What the FMU registers and has printed is.
    """
    c = ctypes.CDLL(None)
    with suppress(AttributeError):  # on_exit: of glibc
        c.on_exit(c._exit, None)  # registered first, so called last
        c.__cxa_atexit(c.fflush, None, None)


def _portable(error: Exception) -> Exception:
    """Return an error that survives the way to the other process; a traceback as text where it does not."""
    try:
        pickle.loads(pickle.dumps(error))
    except Exception:
        return RuntimeError("".join(traceback.format_exception(error)))
    if not hasattr(error, "exit_status"):
        error.add_note("".join(traceback.format_exception(error)))
    return error


def ending_of(status: int) -> str:
    """Say how a process ended, by the status that the kernel has for it."""
    if os.WIFSIGNALED(status):
        number = os.WTERMSIG(status)
        with suppress(ValueError):
            return f"killed by {signal.Signals(number).name}"
        return f"killed by signal {number}"
    return f"exit status {os.WEXITSTATUS(status)}"

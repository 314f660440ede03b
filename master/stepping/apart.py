"""
A run in a process of its own, forked from this one, with rows in shared memory.

Whatever an FMU does to its process (a crash, `exit`, standard output, the working folder, umask, signals)
does not reach this process, which saves the rows. Where the system cannot fork, all runs in this process.
The stepping loop and the libraries that it needs are loaded there alone, while this process loads what
draws and saves: the start of a run costs the longer of the two.
"""

from __future__ import annotations

import ctypes
import math
import os
import pickle
import select
import signal
import sys
import tempfile
import threading
import traceback
import warnings
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path

from master.coupling.schedule import Schedule
from master.errors import FmuError
from master.fmi import unpacked
from master.fmi.messages import LogFile, MessageLog, Said
from master.process import position, signals
from master.process.mailbox import Mailbox
from master.process.position import Call, Position, shared_memory
from master.process.signals import Interruption
from master.process.surroundings import standard_output_as_error
from master.recording.folder import reason
from master.recording.recorder import Recorder, Result
from master.recording.shared_rows import SharedRows
from master.stepping.outcome import FAILED, INTERRUPTED, Outcome, ProgressCallback, RunOptions
from master.system.graph import System
from master.system.grid import Grid

from .recorded import recorded_ports

IS_POSSIBLE = sys.platform.startswith("linux")

_LOOK_SECONDS = 0.05
_PATIENCE = {signal.SIGINT: math.inf}  # until the user insists
_USUAL_PATIENCE = 5.0
_PATIENCE_OUTSIDE_STEPS = 2.0
_DEATH_SIGNAL = 1  # PR_SET_PDEATHSIG


@dataclass(frozen=True)
class Answer:
    """What the process of the FMUs hands over: its outcome, or the error that it ended with."""

    outcome: Outcome | None = None
    error: Exception | None = None


@dataclass(frozen=True)
class Heard:
    """Messages so far: what an FMU said in a call, and all of them."""

    call: Call | None
    text: str
    said: list[Said]


def simulate_apart(
    system: System,
    schedule: Schedule,
    grid: Grid,
    options: RunOptions,
    interruption: Interruption,
    progress: Callable[[], ProgressCallback],
    log_file: LogFile | None = None,
    meanwhile: Callable[[], object] | None = None,
) -> Outcome:
    """
    Step a system over the grid, as `simulate` does, in a process of its own where the system can fork.

    Args:
        system: What to step.
        schedule: In which order.
        grid: When.
        options: Limits, scenario, real time, where rows go.
        interruption: Signals of this process; they end the run.
        progress: Returns what is called with the number of ticks done since the last call.
        log_file: Where messages of FMUs are written.
        meanwhile: Called in a thread while the other process loads and steps.

    Raises:
        FmuError: If an FMU cannot be loaded or initialised; later failures are in the outcome.
    """
    if not IS_POSSIBLE:
        log = MessageLog(grid.time, log_file)
        return _in_this_process(system, schedule, grid, replace(options, log=log), progress())
    with tempfile.TemporaryDirectory(prefix="dockloop-", ignore_cleanup_errors=True) as folder:
        run = _Run(system, schedule, grid, options, Path(folder), log_file)
        run.begin()
        if meanwhile is not None:
            threading.Thread(target=meanwhile).start()
        return run.watch(interruption, progress())


def _in_this_process(
    system: System, schedule: Schedule, grid: Grid, options: RunOptions, progress: ProgressCallback
) -> Outcome:
    from . import simulate

    with standard_output_as_error():
        try:
            return simulate.simulate(system, schedule, grid, options=options, progress=progress)
        except position.Interrupted:
            return Outcome(INTERRUPTED, Recorder([], grid.t0, grid.step_size).result(), 0.0, 0)


class _Run:
    """A run in a process of its own, as seen from here."""

    def __init__(
        self,
        system: System,
        schedule: Schedule,
        grid: Grid,
        options: RunOptions,
        folder: Path,
        log_file: LogFile | None,
    ) -> None:
        self.system = system
        self.schedule = schedule
        self.grid = grid
        self.options = options
        self.folder = folder
        self.log_file = log_file
        self.position = Position(shared_memory(position.N_BYTES))
        self.position.slaves = [(n, i.description.version) for n, i in system.instances.items()]
        ports = recorded_ports(system)
        n_rows = grid.n_ticks + 1
        is_ring = options.sink is not None
        self.rows = SharedRows(self.position, len(ports), n_rows, is_ring=is_ring)
        self.recorder = Recorder(
            ports, grid.t0, grid.step_size, options.keep_every, options.sink, n_rows if is_ring else 1
        )
        self.storage_fault = ""
        self.mailbox = Mailbox()
        self.messages = Mailbox()
        self._process = 0
        self._status: int | None = None

    def begin(self) -> None:
        """Fork."""
        sys.stdout.flush()
        sys.stderr.flush()
        parent = os.getpid()
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", DeprecationWarning)  # threads of numeric libraries, at rest
            self._process = os.fork()
        if self._process == 0:
            try:
                self._step(parent)
            finally:
                os._exit(0)

    def watch(self, interruption: Interruption, progress: ProgressCallback) -> Outcome:
        """Save rows and show progress until the process ends; return how."""
        shown = 0
        was_killed = False
        handle = os.pidfd_open(self._process)
        try:
            while not self._has_ended(handle):
                if interruption or self.storage_fault:
                    self.position.cells[position.STOP] = 1.0
                if not was_killed and self._is_to_be_killed(interruption):
                    os.kill(self._process, signal.SIGKILL)
                    was_killed = True
                self._save(int(self.position.cells[position.WRITTEN]))
                done = max(0, int(self.position.cells[position.WRITTEN]) - 1)
                progress(done - shown)
                shown = done
        except BaseException:
            os.kill(self._process, signal.SIGKILL)
            os.waitpid(self._process, 0)
            raise
        finally:
            os.close(handle)
        return self._outcome(was_killed)

    def _has_ended(self, handle: int) -> bool:
        select.select([handle], [], [], _LOOK_SECONDS)
        ended, status = os.waitpid(self._process, os.WNOHANG)
        if ended:
            self._status = status
        return bool(ended)

    def _is_to_be_killed(self, interruption: Interruption) -> bool:
        if not interruption:
            return False
        patience = _PATIENCE.get(signal.Signals(interruption.number or 0), _USUAL_PATIENCE)
        if self.position.cells[position.STAGE] == position.LOADING:
            patience = _PATIENCE_OUTSIDE_STEPS
        return interruption.insists or interruption.waited() > patience

    def _save(self, end: int) -> None:
        """Hand rows on to the files; what is wrong with those ends the run."""
        if not self.options.sink:
            return
        while len(rows := self.rows.take(end)):
            try:
                if not self.storage_fault:
                    self.recorder.add(rows)
            except OSError as error:
                self.storage_fault = reason(error)

    def _outcome(self, was_killed: bool) -> Outcome:
        end = self.rows.n_complete()
        self._save(end)
        answer = self.mailbox.get()
        if isinstance(answer, Answer) and answer.error is not None:
            raise answer.error
        outcome = answer.outcome if isinstance(answer, Answer) else None
        if outcome is None or not self.position.cells[position.FINISHED]:
            outcome = self._broken_off(outcome, end, was_killed)
        return replace(outcome, result=self._result(end), storage_fault=self.storage_fault)

    def _result(self, end: int) -> Result:
        if self.options.sink:
            return self.recorder.result()
        return self.recorder.as_result(self.rows.all(end))

    def _broken_off(self, outcome: Outcome | None, end: int, was_killed: bool) -> Outcome:
        """Say how a process ended that did not come to its end."""
        call = self.position.call()
        steps = max(0, end - 1)
        heard = self.messages.get() or Heard(None, "", [])
        base = outcome or Outcome(FAILED, self.rows.result(), 0.0, steps, messages=heard.said)
        t = self.grid.time(steps)
        if was_killed:
            within = f"{call.instance} at t={t:.9g} s: did not return from {call.function}" if call else ""
            return replace(base, status=INTERRUPTED, cause=within)
        said = f"ended the process, {_ending(self._status or 0)}"
        where = call.instance if call else "the run"
        said += f", in {call.function}" if call else " in no call of an FMU"
        said += f", after it said {heard.text}" if call and heard.call == call and heard.text else ""
        return replace(base, status=FAILED, error=FmuError(where, said, time=t, status="fatal"))

    def _step(self, parent: int) -> None:
        """In the forked process: step, and hand the outcome over."""
        _die_with(parent)
        position.share_no_further()
        signals.forget()
        unpacked.place_in(self.folder)
        with standard_output_as_error(), position.using(self.position):
            try:
                self.mailbox.put(Answer(outcome=self._simulated()))
            except position.Interrupted:
                empty = self.rows.result()
                self.mailbox.put(Answer(outcome=Outcome(INTERRUPTED, empty, 0.0, 0)))
            except Exception as error:
                self.mailbox.put(Answer(error=_portable(error)))
        self.position.cells[position.FINISHED] = 1.0

    def _simulated(self) -> Outcome:
        from . import simulate

        log = MessageLog(self.grid.time, self.log_file, self._hear)
        options = replace(self.options, sink=None, keep_every=1, recorder=self.rows, log=log)
        begun = simulate.running(self.system, self.schedule, self.grid, options=options)
        try:
            with begun as (outcome, _):
                self.mailbox.put(Answer(outcome=outcome))
                self.position.cells[position.STAGE] = position.ENDING
        finally:
            if self.log_file is not None:
                self.log_file.end()
        return outcome

    def _hear(self, log: MessageLog, fmu: str) -> None:
        """Hand messages over, for the case that the process ends in the call that they come from."""
        self.messages.put(Heard(self.position.call(), log.of_call(fmu), log.summary()))


def _die_with(parent: int) -> None:
    """Let this process end with its parent, however that ends."""
    with suppress(OSError, AttributeError):
        ctypes.CDLL(None).prctl(_DEATH_SIGNAL, signal.SIGKILL)
    if os.getppid() != parent:
        os._exit(0)


def _portable(error: Exception) -> Exception:
    """Return an error that survives the way to the other process; a traceback as text where it does not."""
    try:
        pickle.loads(pickle.dumps(error))
    except Exception:
        return RuntimeError("".join(traceback.format_exception(error)))
    if not hasattr(error, "exit_status"):
        error.add_note("".join(traceback.format_exception(error)))
    return error


def _ending(status: int) -> str:
    if os.WIFSIGNALED(status):
        number = os.WTERMSIG(status)
        with suppress(ValueError):
            return f"killed by {signal.Signals(number).name}"
        return f"killed by signal {number}"
    return f"exit status {os.WEXITSTATUS(status)}"

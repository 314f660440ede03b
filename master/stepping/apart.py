"""
A run in a process of its own, with rows in shared memory: this process saves them.

The stepping loop and the libraries that it needs are loaded there alone, while this process loads what
draws and saves: the start of a run costs the longer of the two.
"""

from __future__ import annotations

import math
import signal
import threading
from collections.abc import Callable
from dataclasses import dataclass, replace

from master.coupling.schedule import Schedule
from master.errors import DataError, FmuError
from master.fmi.messages import LogFile, MessageLog, Said
from master.process import position, signals
from master.process.child import IS_POSSIBLE, Answer, Child, put_off_last_work
from master.process.mailbox import Mailbox
from master.process.memory import is_of_memory
from master.process.position import Call
from master.process.signals import Interruption
from master.process.surroundings import standard_output_as_error
from master.recording.checkpoints import Checkpoint, Mark
from master.recording.folder import reason
from master.recording.recorder import Recorder, Result
from master.recording.shared_rows import SharedRows
from master.stepping.outcome import FAILED, INTERRUPTED, Outcome, ProgressCallback, RunOptions
from master.system.graph import System
from master.system.grid import Grid

from .posted import PostedSnapshots
from .recorded import recorded_ports
from .snapshot import Snapshot

_PATIENCE = {signal.SIGINT: math.inf}  # until the user insists
_USUAL_PATIENCE = 5.0
_PATIENCE_OUTSIDE_STEPS = 2.0


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
    run = _Run(system, schedule, grid, options, log_file)
    other = threading.Thread(target=_prepare, args=[meanwhile or _nothing])
    try:
        run.begin()
        other.start()
        return run.watch(interruption, progress())
    finally:
        run.close()
        if other.is_alive():  # what a next run forks must not hold locks of a thread
            other.join()


def _prepare(work: Callable[[], object]) -> None:
    """Do what will be needed; where there is too little memory, that is said when it is needed."""
    try:
        work()
    except Exception as error:
        if not is_of_memory(error):
            raise


def _nothing() -> None:
    """Do nothing meanwhile."""


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
        log_file: LogFile | None,
    ) -> None:
        self.system = system
        self.schedule = schedule
        self.grid = grid
        self.options = options
        self.log_file = log_file
        self.child = Child()
        self.position = self.child.position
        ports = recorded_ports(system)
        n_rows = grid.n_ticks + 1
        is_ring = options.sink is not None
        self.rows = SharedRows(self.position, len(ports), n_rows, is_ring=is_ring)
        self.recorder = Recorder(
            ports, grid.t0, grid.step_size, options.keep_every, options.sink, n_rows if is_ring else 1
        )
        self.storage_fault = ""
        self.messages = Mailbox()
        self.durable = durable = options.durable
        self.posted = None if durable is None else PostedSnapshots(durable.interval)
        self.begin_at: Snapshot | None = None
        if durable is not None and durable.begin_at is not None:
            self._go_on_from(durable.begin_at)
        if is_ring:
            self.rows.touch()

    def _go_on_from(self, checkpoint: Checkpoint) -> None:
        try:
            self.begin_at = Snapshot.from_bytes(checkpoint.state)
        except ValueError as error:
            raise DataError(f"checkpoint: {error}") from None
        self.rows.go_on(checkpoint.mark.n_rows)
        self.recorder.go_on(checkpoint.mark.n_rows, checkpoint.kept)

    def begin(self) -> None:
        """Let the run begin in a process of its own."""
        self.child.begin(self._step)
        if self.options.sink is not None:
            self.recorder.reserve()  # after the fork: what the child has too is copied when it is filled

    def watch(self, interruption: Interruption, progress: ProgressCallback) -> Outcome:
        """Save rows and show progress until the process ends; return how."""
        shown = 0
        was_killed = False
        while not self.child.has_ended():
            if interruption or self.storage_fault:
                self.position.cells[position.STOP] = 1.0
            if not was_killed and self._is_to_be_killed(interruption):
                self.child.kill()
                was_killed = True
            written = int(self.position.cells[position.WRITTEN])
            self._save_checkpoint()  # after the look at WRITTEN: no row of a later tick is saved before it
            self._save(written)
            done = max(0, int(self.position.cells[position.WRITTEN]) - 1)
            progress(done - shown)
            shown = done
        return self._outcome(was_killed)

    def close(self) -> None:
        """End the process, if it is still there, and remove what it left."""
        self.child.close()

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

    def _save_checkpoint(self) -> None:
        """Save what the run has posted, with the rows up to it."""
        posted = None if self.posted is None else self.posted.take()
        if posted is None or self.durable is None:
            return
        self._save(posted.tick + 1)
        try:
            if not self.storage_fault:
                kept = self.recorder.kept
                mark = Mark(self.recorder.n_rows, len(kept), self.durable.results.mark())
                self.durable.files.save(mark, kept, posted.data)
        except OSError as error:
            self.storage_fault = reason(error)

    def _outcome(self, was_killed: bool) -> Outcome:
        end = self.rows.n_complete()
        self._save_checkpoint()
        self._save(end)
        answer = self.child.mailbox.get()
        if isinstance(answer, Answer) and answer.error is not None:
            raise answer.error
        outcome = answer.result if isinstance(answer, Answer) else None
        if outcome is None or not self.child.is_complete():
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
        where = call.instance if call else "the run"
        said = self.child.ending()
        said += f", after it said {heard.text}" if call and heard.call == call and heard.text else ""
        return replace(base, status=FAILED, error=FmuError(where, said, time=t, status="fatal"))

    def _step(self) -> Outcome:
        """In the child: step."""
        signals.forget()
        put_off_last_work()
        self.rows.touch()
        try:
            return self._simulated()
        except position.Interrupted:
            return Outcome(INTERRUPTED, self.rows.result(), 0.0, 0)

    def _simulated(self) -> Outcome:
        from . import simulate

        log = MessageLog(self.grid.time, self.log_file, self._hear)
        options = replace(
            self.options,
            sink=None,
            keep_every=1,
            recorder=self.rows,
            log=log,
            checkpoints=self.posted,
            begin_at=self.begin_at,
        )
        begun = simulate.running(self.system, self.schedule, self.grid, options=options)
        try:
            with begun as (outcome, _):
                self.child.mailbox.put(Answer(result=outcome))
                self.position.cells[position.STAGE] = position.ENDING
        finally:
            if self.log_file is not None:
                self.log_file.end()
        return outcome

    def _hear(self, log: MessageLog, fmu: str) -> None:
        """Hand messages over, for the case that the process ends in the call that they come from."""
        self.messages.put(Heard(self.position.call(), log.of_call(fmu), log.summary()))

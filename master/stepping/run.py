"""The run itself: chunks of ticks through the stepping loop, and between them all that Python does."""

from __future__ import annotations

import signal
import time
from collections.abc import Mapping
from contextlib import nullcontext
from typing import Any

from master.errors import FmuError
from master.fmi import messages
from master.fmi.slave import Slave
from master.fmi.status import Status
from master.process import position, signals
from master.recording.recorder import Recorder, Rows
from master.stepping.outcome import (
    COMPLETED,
    DIVERGED,
    FAILED,
    INTERRUPTED,
    OVERRUN,
    STOPPED,
    TERMINATED,
    Outcome,
    ProgressCallback,
    RunOptions,
)
from master.system.graph import Port, System
from master.system.grid import Grid
from master.system.scenario import Condition
from master.text.signal_name import SignalName

from .failure import failure_of
from .initialisation import read_initial_values
from .limit_monitor import make_limit_monitor, used_signals, warnings, what_is_beyond
from .machine.compiled import Execute
from .machine.execution import execute_ticks
from .machine.interpreter import Execution, LimitMonitor, Stop
from .machine.operations import Deviation
from .machine.program import Floats, Program
from .recorded import recorded_ports
from .scenario_player import ScenarioPlayer
from .snapshot import Snapshot, arrays_of, layout_of, restore_arrays

_CHUNK_SECONDS = 0.1
_FIRST_CHUNK = 64
_MOST_SHOWN = 12  # values of the FMU that a run was stopped for
_MOST_BYTES_TOUCHED = 2**27
_MOST_TICKS = 16384  # so that rows on their way to a file need the same memory however fast the FMUs are


class RunLoop:
    """One run over the grid; the slaves are initialised."""

    def __init__(
        self, system: System, grid: Grid, program: Program, slaves: Mapping[str, Slave], options: RunOptions
    ) -> None:
        self.system = system
        self.grid = grid
        self.program = program
        self.slaves = slaves
        self.options = options
        self.ports = recorded_ports(system)
        self.position = position.current()
        self.recorder: Rows = options.recorder or Recorder(
            self.ports, grid.t0, grid.step_size, options.keep_every, options.sink, grid.n_ticks + 1
        )
        self.player = ScenarioPlayer(options.scenario, system, program, slaves, grid)
        self.monitor = self._make_monitor()
        self.seconds = 0.0
        self.done = 0

    def run(self, execute: Execute, progress: ProgressCallback) -> Outcome:
        """Execute all ticks; the outcome says how it ended."""
        self.begin(execute)
        with signals.noted([signal.SIGINT]) as interruption:
            outcome = self._step(execute, progress)
        signals.hand_on(interruption)
        return outcome

    def begin(self, execute: Execute) -> None:
        """Record the initial values, or take a snapshot's; load the code of the loop."""
        read_initial_values(self.system, self.slaves, self.program)
        snapshot = self.options.begin_at
        if snapshot is None:
            self.recorder.add(self.program.values[self.monitor.record][None, :])
        else:
            self._go_on_from(snapshot)
        self._execute(execute, 0)
        self.position.cells[position.TICK] = self.done
        self.position.cells[position.STAGE] = position.STEPPING
        self.seconds = 0.0 if snapshot is None else snapshot.seconds

    def snapshot(self) -> Snapshot:
        """
        Return the state of everything at the present tick.

        Raises:
            FmuError: If an FMU does not hand over its state.
        """
        return Snapshot(
            tick=self.done,
            seconds=self.seconds,
            layout=layout_of(self.program, self.monitor),
            fmus={name: slave.state_bytes() for name, slave in self.slaves.items()},
            arrays=arrays_of(self.program, self.monitor),
            player=self.player.as_json(),
            messages=messages.current().state(),
        )

    def _go_on_from(self, snapshot: Snapshot) -> None:
        """Let FMUs and memory have what they had; the FMUs are initialised as at the start of the run."""
        restore_arrays(snapshot, self.program, self.monitor)
        for name, slave in self.slaves.items():
            slave.restore_bytes(snapshot.fmus[name])
        self.player.restore_json(snapshot.player)
        messages.current().restore(dict(snapshot.messages))
        self.done = snapshot.tick

    def _offer_snapshot(self, *, always: bool = False) -> Outcome | None:
        """Hand a snapshot to who wants one; the outcome if an FMU does not give its state."""
        checkpoints = self.options.checkpoints
        if checkpoints is None or not (always or checkpoints.is_due()):
            return None
        try:
            checkpoints.put(self.snapshot())
        except FmuError as error:
            return self._outcome(FAILED, error=error)
        return None

    def advance(self, execute: Execute, ticks: int) -> Outcome | None:
        """Execute some ticks, at most to the end of the grid; the outcome if the run has ended."""
        end = min(self.done + ticks, self.grid.n_ticks)
        if self.done == 0:
            self.player.look(self.monitor.triggers, 0)
            if self.player.stopped is not None:
                return self._stopped(self.player.stopped)
        while self.done < end:
            self.player.advance(self.done)
            ended = self._ended(self._execute(execute, self._chunk(min(end - self.done, _MOST_TICKS))))
            self._report_float_mode()
            if ended is not None:
                return ended
        return None

    def outcome_so_far(self) -> Outcome:
        """Return what has been computed up to now, as that of a run that ends here."""
        return self._outcome(COMPLETED)

    def _step(self, execute: Execute, progress: ProgressCallback) -> Outcome:
        """Execute the ticks, in chunks."""
        pacer, chunk = self.options.pacer, _FIRST_CHUNK
        if self.done == 0:
            self.player.look(self.monitor.triggers, 0)
            if self.player.stopped is not None:
                return self._stopped(self.player.stopped)
        with nullcontext() if pacer is None else pacer.pacing(self.grid.step_size, self._room_to_touch()):
            if pacer is not None:
                self._execute(execute, 0)  # loads the code of the loop that waits
                pacer.begin()
            while self.done < self.grid.n_ticks:
                if self.position.cells[position.STOP]:
                    return self._offer_snapshot(always=True) or self._outcome(INTERRUPTED)
                if refused := self._offer_snapshot():
                    return refused
                self.player.advance(self.done)
                if pacer is not None:
                    chunk = pacer.chunk
                n, before = self._chunk(chunk), self.seconds
                ended = self._ended(self._execute(execute, n))
                self._report_float_mode()
                progress(n)
                if ended is not None:
                    return ended
                share = _CHUNK_SECONDS / max(self.seconds - before, 1e-9)
                chunk = max(1, min(4 * chunk, int(n * share), _MOST_TICKS))
        return self._outcome(COMPLETED)

    def _room_to_touch(self) -> Floats:
        """Memory that rows will be written to, up to a limit."""
        n = min(self.grid.n_ticks, _MOST_BYTES_TOUCHED // (8 * max(1, len(self.ports))))
        return self.recorder.ahead(max(1, n))

    def _chunk(self, wanted: int) -> int:
        """Number of ticks until the next event of the scenario, the end of the run, or as wanted."""
        until_event = self.player.next_tick() - self.done
        return self.recorder.most(max(1, min(wanted, self.grid.n_ticks - self.done, until_event)))

    def _execute(self, execute: Execute, n: int) -> Execution:
        rows = self.recorder.room(n)
        grid = self.grid
        begin = time.perf_counter()
        pacer = self.options.pacer
        pace = None if pacer is None else pacer.address(self.done)
        end = self.done + n
        ended = execute_ticks(
            execute, self.program, self.monitor, grid.t0, grid.step_size, self.done, end, rows, pace
        )
        self.seconds += time.perf_counter() - begin
        messages.current().collect()
        if ended.ticks:
            self.recorder.add(rows[: ended.ticks])
        self.done += ended.ticks
        return ended

    def _report_float_mode(self) -> None:
        """Say whose floating-point mode was undone."""
        cells = self.position.cells
        slave = int(cells[position.FLOAT_MODE]) - 1
        if slave >= 0:
            cells[position.FLOAT_MODE] = 0.0
            self.position.recall(slave, int(cells[position.FLOAT_TICK]))
            name = list(self.system.instances)[slave]
            messages.current().note(name, Status.WARNING, "floating point", messages.CHANGES_FLOAT_MODE)
            self.position.rest(self.done)

    def _ended(self, ended: Execution) -> Outcome | None:
        match ended.stop:
            case Stop.FAILED:
                return self._failed(ended)
            case Stop.NOT_CONVERGED:
                return self._outcome(FAILED, error=self._error(ended))
            case Stop.OUT_OF_LIMITS:
                return self._diverged(ended.where)
            case Stop.LATE:
                return self._outcome(OVERRUN, cause=f"tick {self.done - 1} was not done in time")
            case Stop.ASKED_FOR_END:
                return self._terminated(ended.where)
            case Stop.TRIGGERED:
                self.player.look(self.monitor.triggers, self.done)
                if self.player.stopped is not None:
                    return self._stopped(self.player.stopped)
        return None

    def _outcome(self, status: str, **more: Any) -> Outcome:
        real_time = None if self.options.pacer is None else self.options.pacer.report()
        return Outcome(
            status,
            self.recorder.result(),
            self.seconds,
            self.done,
            real_time=real_time,
            not_reached=self.player.not_reached(),
            happened=self.player.happened(),
            warnings=warnings(self.monitor, self.ports, self.grid),
            **more,
        )

    def _diverged(self, where: int) -> Outcome:
        value = self.program.values[self.monitor.record[where]]
        cause = what_is_beyond(self.ports[where], float(value), float(self.monitor.limits[where]))
        return self._outcome(DIVERGED, cause=cause)

    def _failed(self, ended: Execution) -> Outcome:
        slave = self.slaves[self.program.instance_of(ended.where)]
        if ended.status == Deviation.ENDED_WITHIN or (
            ended.status == Status.DISCARD and slave.asked_for_end()
        ):
            return self._terminated(ended.where)
        return self._outcome(FAILED, error=self._error(ended))

    def _error(self, ended: Execution) -> FmuError:
        return failure_of(self.program, self.slaves, ended, self.grid.time(self.done))

    def _terminated(self, operation: int) -> Outcome:
        """End the run where an FMU asks for it; the rows stay."""
        instance = self.program.instance_of(operation)
        said = self.slaves[instance].last_message()
        cause = f"{instance} at t={self.grid.time(self.done):.15g} s: asks for the end of the simulation"
        return self._outcome(TERMINATED, cause=cause + (f", {said}" if said else ""))

    def _stopped(self, condition: Condition) -> Outcome:
        """End the run by a condition of `stop_when`, and say what its FMU shows there."""
        instance = SignalName(condition.signal).instance
        shown = [
            f"{port.name} {self.program.values[self.program.place[port.name]]:.6g}{_unit(port)}"
            for port in self.ports
            if port.instance == instance
        ]
        listed = ", ".join(shown[:_MOST_SHOWN]) + (", ..." if len(shown) > _MOST_SHOWN else "")
        cause = f"stop_when {condition} at t={self.grid.time(self.done):.15g} s: {listed}"
        return self._outcome(STOPPED, cause=cause)

    def _make_monitor(self) -> LimitMonitor:
        triggers, thresholds = self.player.triggers()
        limits = self.options.limits
        used = used_signals(self.system, limits, self.options.compared, self.player.conditions())
        return make_limit_monitor(self.program, self.ports, limits, used, triggers, thresholds)


def _unit(port: Port) -> str:
    return "" if port.variable.unit_name == "1" else f" {port.variable.unit_name}"

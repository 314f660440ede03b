"""
A system whose FMUs stay loaded from run to run: each run has new instances, the program is compiled once.

A run here computes the bits that it computes in `simulate`.
"""

from __future__ import annotations

from collections.abc import Mapping

from master.coupling.schedule import Schedule
from master.errors import FmuError
from master.fmi import messages
from master.fmi.messages import MessageLog
from master.fmi.slave import Slave
from master.process import position
from master.recording.recorder import Recorder
from master.stepping.machine.compiled import compiled
from master.stepping.machine.program import Program
from master.stepping.outcome import Outcome, RunOptions
from master.stepping.run import RunLoop
from master.system.graph import System
from master.system.grid import Grid

from .compiler import build_program
from .initialisation import initialise
from .recorded import recorded_ports
from .simulate import FATAL, SlaveFactory, free_states, load, load_all

_Shape = tuple[tuple[tuple[str, int], ...], tuple[tuple[str, int], ...]]


class KeptSystem:
    """
    The FMUs of one system, between its runs.

    `is_spent` after a fatal status: nothing of its FMUs may be called any more, here or in new instances.
    """

    def __init__(self, schedule: Schedule, factory: SlaveFactory = load) -> None:
        self.is_spent = False
        self._schedule = schedule
        self._factory = factory
        self._slaves: dict[str, Slave] = {}
        self._failed: dict[str, str] = {}
        self._program: Program | None = None
        self._shape: _Shape = ((), ())
        self._recorder: Recorder | None = None

    def run(self, system: System, grid: Grid, options: RunOptions) -> Outcome:
        """
        Step the system over the grid.

        Args:
            system: As in the runs before but for its start values.
            grid: When.
            options: What else the run does; its rows are good until the next run.

        Raises:
            FmuError: If an FMU cannot be loaded or initialised; later failures are in the outcome.
        """
        assert not self.is_spent, "an FMU of this process has answered with a fatal status"
        log = MessageLog(grid.time)
        position.current().begin(grid.t0, grid.step_size)
        with messages.collecting(log):
            try:
                self._renew(system)
                stop = grid.stop({i.every for i in system.instances.values()})
                initialise(system, self._schedule, self._slaves, grid.t0, stop)
                program = self._fresh_program(system, options)
                recorder = self._empty_recorder(system, grid)
                loop = RunLoop(system, grid, program, self._slaves, options.with_recorder(recorder))
                outcome = loop.run(compiled(), _silent)
                if outcome.error is not None:
                    self._note_failure(outcome.error)
                free_states(program, self._slaves, self._failed)
            except FmuError as error:
                self._note_failure(error)
                raise
        outcome.messages = log.summary()
        return outcome

    def close(self) -> None:
        """End all FMUs."""
        for name, slave in self._slaves.items():
            slave.close(failed=name in self._failed, fatal=self._failed.get(name) == FATAL)
        self._slaves.clear()

    def _note_failure(self, error: FmuError) -> None:
        self._failed[error.instance] = error.status
        self.is_spent = self.is_spent or error.status == FATAL

    def _renew(self, system: System) -> None:
        """Load the FMUs for the first run, make new instances for each later one."""
        failed = self._failed
        self._failed = {}
        if set(self._slaves) != set(system.instances):
            self.close()
            load_all(system, self._slaves, self._factory)
            return
        for name, slave in self._slaves.items():
            slave.renew(failed=name in failed)

    def _fresh_program(self, system: System, options: RunOptions) -> Program:
        """Return the program as it is before the first tick of a run."""
        columns = options.inputs.columns
        channels = options.scenario.channels()
        shape = (tuple(columns.items()), tuple(channels.items()))
        if self._program is None or shape != self._shape:
            self._shape = shape
            self._program = build_program(system, self._schedule, self._slaves, channels, measured=columns)
        else:
            _forget_run(self._program, self._slaves)
        if options.inputs.values is not None:
            self._program.feed(options.inputs.values)
        return self._program

    def _empty_recorder(self, system: System, grid: Grid) -> Recorder:
        kept = self._recorder
        if kept is None or (kept.t0, kept.step_size) != (grid.t0, grid.step_size):
            ports = recorded_ports(system)
            kept = Recorder(ports, grid.t0, grid.step_size, most_rows=grid.n_ticks + 1)
            self._recorder = kept
        kept.cut(0)
        return kept


def _forget_run(program: Program, slaves: Mapping[str, Slave]) -> None:
    """Clear what a run left in a program, and let it call the new instances."""
    memory = program.memory
    for i, name in enumerate(program.names):
        memory.slaves[i, 0] = slaves[name].interface().component
    memory.values[:] = 0.0
    memory.rings[:] = 0.0
    memory.states[:] = 0
    memory.channels[:] = 0.0
    memory.loops[:, -1] = 0


def _silent(ticks: int) -> None:
    """Show nothing."""

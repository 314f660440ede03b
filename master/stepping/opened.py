"""
A run that stays open: stepped as far as asked, read, changed, saved and taken back.

Several of them may be open at a time. What belongs to one run (its position, its messages) is in place
while it works; one thread at a time does, whichever it is.
"""

from __future__ import annotations

import threading
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass, replace
from types import TracebackType

import numpy as np

from master.coupling.schedule import Schedule
from master.errors import ConfigError, FmuError, Problem
from master.fmi import messages
from master.fmi.description import Variable
from master.fmi.messages import MessageLog
from master.fmi.saved_state import StateCall, call_state
from master.fmi.slave import Slave
from master.fmi.status import Status, described, status_name
from master.fmi.values import settable
from master.process import position
from master.process.position import Position
from master.recording.recorder import Recorder
from master.stepping.machine.compiled import compiled
from master.stepping.machine.program import Floats, Integers
from master.stepping.outcome import Outcome, RunOptions
from master.stepping.run import RunLoop
from master.stepping.scenario_player import PlayerState
from master.system.graph import Port, System, signal_fault
from master.system.grid import Grid
from master.text.scalar import Setting
from master.text.signal_name import SignalName

from .compiler import build_program
from .initialisation import initialise
from .recorded import recorded_ports
from .simulate import FATAL, SlaveFactory, load, load_all

WORKING = threading.RLock()
"""Held while a run works: where it is and what its FMUs say is known to the process, not to a thread."""


@dataclass(frozen=True)
class RunState:
    """All of a run at one tick; good for the run that it was saved from, as often as wanted."""

    tick: int
    fmus: Integers
    values: Floats
    rings: Floats
    channels: Floats
    triggers: Integers
    first_beyond: Integers
    player: PlayerState


class OpenRun:
    """
    A system whose FMUs are loaded and initialised.

    `ended` is the outcome of a run that cannot go on: diverged, failed, or ended by an FMU.
    """

    def __init__(
        self,
        system: System,
        schedule: Schedule,
        grid: Grid,
        options: RunOptions,
        factory: SlaveFactory = load,
    ) -> None:
        """
        Load and initialise.

        Raises:
            FmuError: If an FMU cannot be loaded or initialised.
        """
        self.system = system
        self.grid = grid
        self.ended: Outcome | None = None
        self._position = Position()
        self._log = MessageLog(grid.time)
        self._slaves: dict[str, Slave] = {}
        self._failed: dict[str, str] = {}
        self._states: list[Integers] = []
        self._is_closed = False
        self._connected = {wire.target.name for wire in system.wires} | set(options.inputs.columns)
        with self._working(), self._closing_on_failure():
            self._position.begin(grid.t0, grid.step_size)
            load_all(system, self._slaves, factory)
            stop = grid.stop({i.every for i in system.instances.values()})
            initialise(system, schedule, self._slaves, grid.t0, stop)
            columns = options.inputs.columns
            channels = options.scenario.channels()
            program = build_program(system, schedule, self._slaves, channels, measured=columns)
            if options.inputs.values is not None:
                program.feed(options.inputs.values)
            self._program = program
            rows = Recorder(recorded_ports(system), grid.t0, grid.step_size, most_rows=grid.n_ticks + 1)
            self._recorder = rows
            self._loop = RunLoop(system, grid, program, self._slaves, replace(options, recorder=rows))
            self._execute = compiled()
            self._loop.begin(self._execute)

    @property
    def tick(self) -> int:
        """Ticks done."""
        return self._loop.done

    def step(self, ticks: int) -> None:
        """
        Execute some ticks, at most to the end of the grid or of the run.

        Raises:
            ConfigError: If the run is closed or cannot go on.
            FmuError: If an FMU fails; what was computed stays.
        """
        self._require_open()
        if self.ended is not None:
            problem = Problem(
                f"the run {self.ended.status}", where=self._where(), expected="a restored state"
            )
            raise ConfigError([problem])
        with self._working():
            self.ended = self._loop.advance(self._execute, ticks)
        if self.ended is not None and self.ended.error is not None:
            self._failed[self.ended.error.instance] = self.ended.error.status
            raise self.ended.error

    def get(self, signal: str) -> float:
        """
        Read any variable at the present tick.

        Raises:
            ConfigError: If there is no such variable, or the run is closed.
        """
        self._require_open()
        self._refuse_unknown(signal)
        place = self._program.place.get(self.system.primary(signal).name, self._program.place.get(signal))
        if place is not None:
            return float(self._program.values[place])
        port = self.system.port(signal)
        with self._working():
            [value] = self._slaves[port.instance].get([port.variable])
        return value

    def set(self, signal: str, value: Setting) -> None:
        """
        Set a tunable parameter or an input that is not connected; it acts from the next tick on.

        Raises:
            ConfigError: If that cannot be set now, or does not take the value.
            FmuError: If the FMU refuses.
        """
        self._require_open()
        self._refuse_unknown(signal)
        name, key = SignalName(signal).parts
        description = self.system.instances[name].description
        try:
            found = settable(description, name, key, value, self._connected)
        except ValueError as error:
            raise ConfigError([Problem.of_line(f"set {signal}: {error}")]) from None
        variables = [description.by_name[n] for n in found]
        problems = [p for p in map(self._fault_of_setting, [name] * len(variables), variables) if p]
        if problems:
            raise ConfigError(problems)
        with self._working():
            self._slaves[name].set(variables, list(found.values()))  # type: ignore[arg-type]  # texts too
        for variable, given in zip(variables, found.values(), strict=True):
            place = self._program.place.get(Port(name, variable).name)
            if place is not None:  # an element of an array that is set as a whole in each step
                self._program.values[place] = given

    def save(self) -> RunState:
        """
        Keep the state of everything at the present tick.

        Raises:
            ConfigError: With each FMU that cannot save its state, or if the run cannot go on.
            FmuError: If an FMU fails to.
        """
        self._require_open()
        instances = self.system.instances.items()
        unable = [name for name, i in instances if not i.description.can_get_and_set_state]
        problems = [
            Problem("cannot save its state", where=name, expected="an FMU with canGetAndSetFMUState")
            for name in unable
        ]
        if self.ended is not None:
            problems.append(
                Problem(f"the run {self.ended.status}", where=self._where(), expected="one that goes on")
            )
        if problems:
            raise ConfigError(problems)
        states = np.zeros(len(self._slaves), dtype=np.int64)
        with self._working():
            for i, name in enumerate(self._slaves):
                self._state_call(name, StateCall.SAVE, states.ctypes.data + 8 * i)
        self._states.append(states)
        memory = self._program.memory
        monitor = self._loop.monitor
        return RunState(
            tick=self._loop.done,
            fmus=states,
            values=memory.values.copy(),
            rings=memory.rings.copy(),
            channels=memory.channels.copy(),
            triggers=monitor.triggers.copy(),
            first_beyond=monitor.first_beyond.copy(),
            player=self._loop.player.state(),
        )

    def restore(self, state: RunState) -> None:
        """
        Go back to a saved state; rows after it are forgotten.

        Raises:
            ConfigError: If it is the state of another run, or an FMU has failed since.
            FmuError: If an FMU fails to.
        """
        self._require_open()
        if not any(state.fmus is own for own in self._states):
            raise ConfigError(
                [Problem("state of another run", where=self._where(), expected="one saved here")]
            )
        if self._failed:
            names = ", ".join(self._failed)
            raise ConfigError([Problem(f"{names} failed", where=self._where(), expected="a new run")])
        with self._working():
            for i, name in enumerate(self._slaves):
                self._state_call(name, StateCall.RESTORE, int(state.fmus[i]))
        memory = self._program.memory
        monitor = self._loop.monitor
        memory.values[:] = state.values
        memory.rings[:] = state.rings
        memory.channels[:] = state.channels
        monitor.triggers[:] = state.triggers
        monitor.first_beyond[:] = state.first_beyond
        self._loop.player.restore(state.player)
        self._loop.done = state.tick
        self._recorder.cut(state.tick + 1)
        self.ended = None

    def outcome(self) -> Outcome:
        """Return what has been computed up to now, as a copy."""
        outcome = self.ended or self._loop.outcome_so_far()
        rows = replace(outcome.result, values=outcome.result.values.copy())
        return replace(outcome, result=rows, messages=self._log.summary())

    def close(self) -> None:
        """End all FMUs; once is enough."""
        if self._is_closed:
            return
        self._is_closed = True
        with self._working():
            for states in self._states:
                for i, name in enumerate(self._slaves):
                    if name not in self._failed:
                        with suppress(FmuError):
                            self._state_call(name, StateCall.FREE, states.ctypes.data + 8 * i)
            for name, slave in self._slaves.items():
                slave.close(failed=name in self._failed, fatal=self._failed.get(name) == FATAL)

    def __enter__(self) -> OpenRun:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    @contextmanager
    def _working(self) -> Iterator[None]:
        with WORKING, position.using(self._position), messages.collecting(self._log):
            yield

    @contextmanager
    def _closing_on_failure(self) -> Iterator[None]:
        try:
            yield
        except BaseException as error:
            if isinstance(error, FmuError):
                self._failed[error.instance] = error.status
            self.close()
            raise

    def _state_call(self, name: str, call: StateCall, argument: int) -> None:
        status = call_state(self._slaves[name], call, argument)
        if status not in (Status.OK, Status.WARNING):
            said = self._slaves[name].last_message() or f"state not saved or restored, {described(status)}"
            raise FmuError(name, said, time=self.grid.time(self.tick), status=status_name(status))

    def _fault_of_setting(self, instance: str, variable: Variable) -> Problem | None:
        is_input = variable.causality == "input"
        if is_input or (variable.causality == "parameter" and variable.variability == "tunable"):
            return None
        what = (
            "is fixed during a run"
            if variable.causality == "parameter"
            else f"is of kind {variable.causality}"
        )
        where = f"set {instance}.{variable.name}"
        return Problem(what, where=where, expected="a tunable parameter or an input that is not connected")

    def _refuse_unknown(self, signal: str) -> None:
        fault = signal_fault(self.system.descriptions, signal, None)
        if fault is not None:
            raise ConfigError([fault])

    def _require_open(self) -> None:
        if self._is_closed:
            raise ConfigError([Problem("the run is closed", where=self._where(), expected="an open one")])

    def _where(self) -> str:
        return f"t={self.grid.time(self.tick):.9g} s"

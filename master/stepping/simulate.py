"""A simulation from the loading of its FMUs to their end, whatever happens between."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager

from master.coupling.schedule import Schedule
from master.errors import FmuError
from master.fmi import messages
from master.fmi.description import Description
from master.fmi.fmi2 import Fmi2Slave
from master.fmi.fmi3 import Fmi3Slave
from master.fmi.messages import MessageLog
from master.fmi.saved_state import StateCall, call_state
from master.fmi.slave import Slave
from master.fmi.status import described, status_name
from master.process import position, signals
from master.stepping.machine.compiled import compiled as compiled_execute
from master.stepping.machine.interpreter import execute
from master.stepping.machine.operations import is_bad
from master.stepping.machine.program import Program
from master.stepping.outcome import Outcome, ProgressCallback, RunOptions
from master.stepping.run import RunLoop
from master.system.graph import System
from master.system.grid import Grid

from .compiler import build_program
from .initialisation import initialise

FATAL = "fatal"

SlaveFactory = Callable[[str, Description], Slave]


def load(name: str, description: Description) -> Slave:
    """Load an FMU of either version."""
    return Fmi2Slave(name, description) if description.version == 2 else Fmi3Slave(name, description)


def load_all(system: System, slaves: dict[str, Slave], factory: SlaveFactory = load) -> None:
    """
    Load the FMUs of a system into `slaves`: those in processes of their own first, which then hold no others.

    What was loaded before one fails is in `slaves`, in the order of the system.
    """
    isolated = [i for i in system.instances.values() if i.isolation is not None]
    others = [i for i in system.instances.values() if i.isolation is None]
    loaded: dict[str, Slave] = {}
    try:
        for instance in isolated:
            from master.isolation.slave import IsolatedSlave

            assert instance.isolation is not None
            loaded[instance.name] = IsolatedSlave(
                instance.name, instance.description, instance.isolation, factory, len(isolated)
            )
        for instance in others:
            loaded[instance.name] = factory(instance.name, instance.description)
    finally:
        slaves.update({name: loaded[name] for name in system.instances if name in loaded})


def _silent(ticks: int) -> None:
    """Show nothing."""


def simulate(
    system: System,
    schedule: Schedule,
    grid: Grid,
    *,
    options: RunOptions | None = None,
    factory: SlaveFactory = load,
    progress: ProgressCallback = _silent,
    compiled: bool = True,
) -> Outcome:
    """
    Step a system over the grid.

    Args:
        system: What to step.
        schedule: In which order.
        grid: When.
        options: Limits, scenario, real time, where rows go.
        factory: Makes the slaves; tests give stubs.
        progress: Called with the number of ticks done since the last call.
        compiled: Whether the stepping loop runs as compiled code.

    Raises:
        FmuError: If an FMU cannot be loaded or initialised; later failures are in the outcome.
    """
    run = running(
        system, schedule, grid, options=options, factory=factory, progress=progress, compiled=compiled
    )
    with run as (outcome, _):
        return outcome


@contextmanager
def running(
    system: System,
    schedule: Schedule,
    grid: Grid,
    *,
    options: RunOptions | None = None,
    factory: SlaveFactory = load,
    progress: ProgressCallback = _silent,
    compiled: bool = True,
) -> Iterator[tuple[Outcome, Mapping[str, Slave]]]:
    """Step a system as `simulate` does; yields its FMUs too, which end after the block."""
    options = options or RunOptions()
    log = options.log or MessageLog(grid.time)
    slaves: dict[str, Slave] = {}
    failed: dict[str, str] = {}
    outcome: Outcome | None = None
    position.current().begin(grid.t0, grid.step_size)
    signals.remind()
    with messages.collecting(log):
        try:
            load_all(system, slaves, factory)
            stop = grid.stop({i.every for i in system.instances.values()})
            initialise(system, schedule, slaves, grid.t0, stop)
            inputs = options.inputs
            program = build_program(
                system, schedule, slaves, options.scenario.channels(), measured=inputs.columns
            )
            if inputs.values is not None:
                program.feed(inputs.values)
            loop = RunLoop(system, grid, program, slaves, options)
            outcome = loop.run(compiled_execute() if compiled else execute, progress)
            outcome.messages = log.summary()
            if outcome.error is not None:
                failed[outcome.error.instance] = outcome.error.status
            free_states(program, slaves, failed)
            yield outcome, slaves
        except FmuError as error:
            failed[error.instance] = error.status
            raise
        finally:
            for name, slave in slaves.items():
                slave.close(failed=name in failed, fatal=failed.get(name) == FATAL)
            if outcome is not None:
                outcome.messages = log.summary()


def free_states(program: Program, slaves: Mapping[str, Slave], failed: dict[str, str]) -> None:
    """Free the saved states of iterated groups; an FMU that refuses is noted."""
    states = program.memory.states
    for i, name in enumerate(program.names):
        if not states[i] or name in failed:
            continue
        status = call_state(slaves[name], StateCall.FREE, states.ctypes.data + 8 * i)
        if is_bad(status):
            failed[name] = status_name(status)
            answer = f"the call that frees its state answered with {described(status)}"
            messages.current().note(name, status, messages.AT_THE_END, answer)

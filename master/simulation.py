"""A run: create the slaves, initialise, step in chunks, and end well whatever happens."""

from __future__ import annotations

import signal
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from . import stepping
from .description import Description
from .errors import FmuError
from .fmi2 import Fmi2Slave
from .fmi3 import Fmi3Slave
from .fmu import STATUS
from .graph import Port, System, Wire
from .program import Program
from .recorder import Recorder, Result
from .schedule import Schedule
from .slave import Slave
from .translation import build_program

SlaveFactory = Callable[[str, Description], Slave]
ProgressCallback = Callable[[int], None]

COMPLETED, DIVERGED, FAILED, INTERRUPTED = "completed", "diverged", "failed", "interrupted"
_CHUNK_SECONDS = 0.1
_FIRST_CHUNK = 64


@dataclass(frozen=True)
class Grid:
    """The time grid: tick k goes from t0 + k h to t0 + (k+1) h [s]."""

    t0: float
    step_size: float
    n_ticks: int


@dataclass
class Outcome:
    """How a run ended and what it computed; `error` says why if it failed, `cause` why it diverged."""

    status: str
    result: Result
    seconds: float
    error: FmuError | None = None
    cause: str = ""

    @property
    def steps(self) -> int:
        """Number of complete steps."""
        return len(self.result.time) - 1


def _silent(ticks: int) -> None:
    """Show nothing."""


def load(name: str, description: Description) -> Slave:
    """Load an FMU of either version."""
    return Fmi2Slave(name, description) if description.version == 2 else Fmi3Slave(name, description)


def simulate(
    system: System,
    schedule: Schedule,
    grid: Grid,
    *,
    limits: Mapping[str, float] | None = None,
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
        limits: Largest magnitude by signal; a run that exceeds one ends as diverged.
        factory: Makes the slaves; tests give stubs.
        progress: Called with the number of ticks done since the last call.
        compiled: Whether the stepping loop runs as compiled code.

    Raises:
        FmuError: If an FMU cannot be loaded or initialised; later failures are in the outcome.
    """
    slaves: dict[str, Slave] = {}
    failed: set[str] = set()
    try:
        for name, instance in system.instances.items():
            slaves[name] = factory(name, instance.description)
        _initialise(system, schedule, slaves, grid.t0)
        run = _Run(system, grid, build_program(system, schedule, slaves), limits or {})
        run.read_initial_values(slaves)
        outcome = run.step(stepping.compiled() if compiled else stepping.execute, progress, slaves)
        if outcome.error is not None:
            failed.add(outcome.error.instance)
        return outcome
    except FmuError as error:
        failed.add(error.instance)
        raise
    finally:
        for name, slave in slaves.items():
            slave.close(failed=name in failed)


def _initialise(system: System, schedule: Schedule, slaves: Mapping[str, Slave], t0: float) -> None:
    """Enter initialisation, let the initial values run through the wires until they stand, and leave it."""
    for name, slave in slaves.items():
        slave.enter_initialisation(system.instances[name].start, t0)
    order = [name for group in schedule.groups for name in group]
    sent: dict[str, float] = {}
    for _ in range(len(order) + 1):
        moved = [wire for name in order for wire in _pull(system, slaves, name, sent)]
        if not moved:
            break
    else:
        names = ", ".join(f"{w.source.name} -> {w.target.name}" for w in moved)
        raise FmuError(
            moved[0].target.instance,
            f"initial values do not settle, got changes on {names}, expected no algebraic loop at the start",
        )
    for slave in slaves.values():
        slave.exit_initialisation()


def _pull(system: System, slaves: Mapping[str, Slave], name: str, sent: dict[str, float]) -> list[Wire]:
    """Set the inputs of one slave to its sources' present values; give the wires whose value changed."""
    moved = []
    for wire in system.wires_into(name):
        [value] = slaves[wire.source.instance].get([wire.source.variable])
        value = wire.conversion.factor * value + wire.conversion.offset
        if value != sent.get(wire.target.name):
            slaves[name].set([wire.target.variable], [value])
            sent[wire.target.name] = value
            moved.append(wire)
    return moved


@dataclass
class _Run:
    system: System
    grid: Grid
    program: Program
    limits: Mapping[str, float]
    recorder: Recorder = field(init=False)

    def __post_init__(self) -> None:
        self.ports = [
            Port(name, v) for name, i in self.system.instances.items() for v in i.description.outputs
        ]
        self.recorder = Recorder(self.ports, self.grid.t0, self.grid.step_size)
        names = [p.name for p in self.ports]
        self.record = np.array([self.program.place[n] for n in names], dtype=np.int64)
        self.bounds = np.array([self.limits.get(n, np.inf) for n in names])

    def read_initial_values(self, slaves: Mapping[str, Slave]) -> None:
        """Row 0, and what the rings of delayed connections hold until their first value arrives."""
        values, place = self.program.values, self.program.place
        for name, instance in self.system.instances.items():
            outputs = instance.description.outputs
            for v, value in zip(outputs, slaves[name].get(outputs), strict=True):
                values[place[Port(name, v).name]] = value
        for wire in self.system.wires:
            source = values[place[wire.source.name]]
            values[place[wire.target.name]] = wire.conversion.factor * source + wire.conversion.offset
        self.program.fill_rings()
        self.recorder.add(values[self.record][None, :])

    def step(
        self, execute: Callable[..., Any], progress: ProgressCallback, slaves: Mapping[str, Slave]
    ) -> Outcome:
        n, done, chunk = self.grid.n_ticks, 0, _FIRST_CHUNK
        watch = stepping.Watch(self.record, self.bounds, np.zeros((0, 2), dtype=np.int64), np.zeros((0, 2)))
        grid = (self.grid.t0, self.grid.step_size)
        stepped = 0.0
        with _interruptible() as interrupted:
            while done < n:
                if interrupted():
                    return self._outcome(INTERRUPTED, stepped)
                end = min(n, done + chunk)
                rows = np.empty((end - done, len(self.record)))
                begin = time.perf_counter()
                outcome, ticks, where, status = execute(self.program.memory, watch, grid, (done, end), rows)
                seconds = time.perf_counter() - begin
                stepped += seconds
                self.recorder.add(rows[:ticks])
                done += ticks
                progress(ticks)
                if outcome == stepping.FAILED:
                    return self._failed(where, status, done, slaves, stepped)
                if outcome == stepping.OUT_OF_LIMITS:
                    return self._diverged(where, rows[ticks - 1, where], stepped)
                chunk = max(1, min(4 * chunk, int(chunk * _CHUNK_SECONDS / max(seconds, 1e-9))))
        return self._outcome(COMPLETED, stepped)

    def _outcome(self, status: str, seconds: float, **more: Any) -> Outcome:
        return Outcome(status, self.recorder.result(), seconds, **more)

    def _diverged(self, signal_index: int, value: float, seconds: float) -> Outcome:
        port, bound = self.ports[signal_index], self.bounds[signal_index]
        unit = port.variable.unit_name
        cause = f"{port.name}: got {value:.6g} {unit}, expected a magnitude of at most {bound:.6g} {unit}"
        return self._outcome(DIVERGED, seconds, cause=cause)

    def _failed(
        self, operation: int, status: int, tick: int, slaves: Mapping[str, Slave], seconds: float
    ) -> Outcome:
        instance = self.program.instance_of(operation)
        name = STATUS[status] if 0 <= status < len(STATUS) else str(status)
        message = slaves[instance].last_message() or f"answered with status {name}"
        at = self.grid.t0 + tick * self.grid.step_size
        return self._outcome(FAILED, seconds, error=FmuError(instance, message, time=at, status=name))


@contextmanager
def _interruptible() -> Iterator[Callable[[], bool]]:
    """Note Ctrl-C instead of raising it inside an FMU; outside the main thread nothing is changed."""
    seen: list[int] = []
    try:
        previous = signal.signal(signal.SIGINT, lambda *what: seen.append(what[0]))
    except ValueError:
        yield lambda: False
        return
    try:
        yield lambda: bool(seen)
    finally:
        signal.signal(signal.SIGINT, previous)

"""The run itself: chunks of ticks through the stepping loop, and between them all that Python does."""

from __future__ import annotations

import signal
import time
from collections.abc import Callable, Mapping
from contextlib import nullcontext
from typing import Any

import numpy as np

from master.errors import FmuError
from master.fmi import messages
from master.fmi.loaded_fmu import STATUS
from master.fmi.native.cells import first_misfit
from master.fmi.slave import Slave
from master.fmi.value_types import NAMES, RANGES
from master.process import position, signals
from master.recording.recorder import Recorder, Rows
from master.stepping.machine.operations import ENDED_WITHIN, MISFIT, STOOD_STILL, WANTED_EVENTS
from master.stepping.machine.program import WARNING, Program
from master.stepping.outcome import (
    COMPLETED,
    DIVERGED,
    FAILED,
    INTERRUPTED,
    OVERRUN,
    TERMINATED,
    Outcome,
    RunOptions,
)
from master.system.graph import Port, System
from master.system.grid import Grid

from .machine import interpreter
from .scenario_player import Director

DISCARD = STATUS.index("discard")
_DEVIATIONS = {
    STOOD_STILL: "returned early from a step without getting on, expected the step's end",
    WANTED_EVENTS: "asks for event mode, which it was not given, expected that it handles its events itself",
}

_CHUNK_SECONDS = 0.1
_FIRST_CHUNK = 64
_MOST_TICKS = 16384  # so that rows on their way to a file need the same memory however fast the FMUs are
_TIME_TOLERANCE = 1e-6  # of a step

Execute = Callable[..., tuple[int, int, int, int]]
ProgressCallback = Callable[[int], None]


def recorded_ports(system: System) -> list[Port]:
    """List what a run records: all outputs."""
    return [Port(n, v) for n, i in system.instances.items() for v in i.description.outputs]


class RunLoop:
    """One run over the grid; the slaves are initialised."""

    def __init__(
        self, system: System, grid: Grid, program: Program, slaves: Mapping[str, Slave], options: RunOptions
    ) -> None:
        self.system, self.grid, self.program, self.slaves = system, grid, program, slaves
        self.options = options
        self.ports = recorded_ports(system)
        self.position = position.current()
        self.recorder: Rows = options.recorder or Recorder(
            self.ports, grid.t0, grid.step_size, options.keep_every, options.sink, grid.n_ticks + 1
        )
        self.director = Director(options.scenario, system, program, slaves)
        self.watch = self._make_watch()
        self.seconds = 0.0
        self.done = 0

    def run(self, execute: Execute, progress: ProgressCallback) -> Outcome:
        """Execute all ticks; the outcome says how it ended."""
        self._read_initial_values()
        self._execute(execute, 0)
        self.position.leave()
        self.position.cells[position.STAGE] = position.STEPPING
        self.seconds = 0.0
        pacer, chunk = self.options.pacer, _FIRST_CHUNK
        self.director.look(self.watch.triggers, self.grid.t0)
        with signals.noted([signal.SIGINT]), nullcontext() if pacer is None else pacer.pacing():
            while self.done < self.grid.n_ticks:
                if self.position.cells[position.STOP]:
                    return self._outcome(INTERRUPTED)
                self.director.advance(self.grid.time(self.done), _TIME_TOLERANCE * self.grid.step_size)
                if pacer is not None:
                    pacer.wait(self.done, self.grid.step_size)
                    chunk = 1
                n, before = self._chunk(chunk), self.seconds
                ended = self._ended(*self._execute(execute, n))
                self._report_float_mode()
                progress(n)
                if ended is not None:
                    return ended
                if pacer is not None and not pacer.done(self.done - 1, self.grid.step_size):
                    return self._outcome(OVERRUN, cause=f"tick {self.done - 1} was not done in time")
                share = _CHUNK_SECONDS / max(self.seconds - before, 1e-9)
                chunk = max(1, min(4 * chunk, int(n * share), _MOST_TICKS))
        return self._outcome(COMPLETED)

    def _chunk(self, wanted: int) -> int:
        """Number of ticks until the next event of the scenario, the end of the run, or as wanted."""
        left = self.director.next_time() - self.grid.time(self.done)
        until_event = np.ceil(left / self.grid.step_size - _TIME_TOLERANCE)
        return self.recorder.most(int(max(1, min(wanted, self.grid.n_ticks - self.done, until_event))))

    def _execute(self, execute: Execute, n: int) -> tuple[int, int, int]:
        rows = self.recorder.room(n)
        grid, ticks = (self.grid.t0, self.grid.step_size), (self.done, self.done + n)
        begin = time.perf_counter()
        outcome, complete, where, status = execute(self.program.memory, self.watch, grid, ticks, rows)
        self.seconds += time.perf_counter() - begin
        if complete:
            self.recorder.add(rows[:complete])
        self.done += complete
        return outcome, where, status

    def _report_float_mode(self) -> None:
        """Say whose floating-point mode was undone."""
        cells = self.position.cells
        slave = int(cells[position.FLOAT_MODE])
        if slave:
            cells[position.FLOAT_MODE] = 0.0
            cells[position.TICK] = cells[position.FLOAT_TICK]
            name = self.program.names[slave - 1]
            messages.current().note(name, WARNING, "floating point", messages.CHANGES_FLOAT_MODE)

    def _ended(self, outcome: int, where: int, status: int) -> Outcome | None:
        if outcome == interpreter.FAILED:
            return self._failed(where, status)
        if outcome == interpreter.NOT_CONVERGED:
            return self._not_converged(where)
        if outcome == interpreter.OUT_OF_LIMITS:
            return self._diverged(where)
        if outcome == interpreter.ENDED:
            return self._terminated(where)
        if outcome == interpreter.TRIGGERED:
            self.director.look(self.watch.triggers, self.grid.time(self.done))
        return None

    def _outcome(self, status: str, **more: Any) -> Outcome:
        real_time = None if self.options.pacer is None else self.options.pacer.report()
        result = self.recorder.result()
        more["not_reached"] = self.director.not_reached()
        return Outcome(status, result, self.seconds, self.done, real_time=real_time, **more)

    def _diverged(self, where: int) -> Outcome:
        port, bound = self.ports[where], self.watch.limits[where]
        value, unit = self.program.values[self.watch.record[where]], port.variable.unit_name
        cause = f"{port.name}: got {value:.6g} {unit}, expected a magnitude of at most {bound:.6g} {unit}"
        return self._outcome(DIVERGED, cause=cause)

    def _failed(self, operation: int, status: int) -> Outcome:
        instance = self.program.instance_of(operation)
        slave = self.slaves[instance]
        if status == ENDED_WITHIN or (status == DISCARD and slave.asked_for_end()):
            return self._terminated(operation)
        name = STATUS[status] if 0 <= status < len(STATUS) else "error"
        said = (
            self._misfit(operation)
            if status == MISFIT
            else _DEVIATIONS.get(status) or slave.last_message() or f"answered with status {name}"
        )
        error = FmuError(instance, said, time=self.grid.time(self.done), status=name)
        return self._outcome(FAILED, error=error)

    def _misfit(self, operation: int) -> str:
        """Name the first value that the type of its input does not hold."""
        memory, values = self.program.memory, self.program.values
        first, behind = memory.slaves[memory.operations[operation, 2], 3:5]
        for *_, n, kind, place in memory.blocks[first:behind].tolist():
            misfit = first_misfit(values[place:].ctypes.data, n, kind)
            if misfit >= 0:
                break
        place += misfit
        signal = next(name for name, at in self.program.place.items() if at == place)
        least, largest = RANGES[kind]
        return (
            f"{signal}: value does not fit {NAMES[kind]}, got {values[place]:g}, "
            f"expected from {least:g} to {largest:g}"
        )

    def _terminated(self, operation: int) -> Outcome:
        """End the run where an FMU asks for it; the rows stay."""
        instance = self.program.instance_of(operation)
        said = self.slaves[instance].last_message()
        cause = f"{instance} at t={self.grid.time(self.done):.9g} s: asks for the end of the simulation"
        return self._outcome(TERMINATED, cause=cause + (f", {said}" if said else ""))

    def _not_converged(self, row: int) -> Outcome:
        memory = self.program.memory
        source, target, c = memory.residuals[row]
        sent = memory.conversions[c, 0] * memory.values[source] + memory.conversions[c, 1]
        residual = abs(sent - memory.values[target])
        wire = self.program.loop_wires[row]
        message = (
            f"the iteration over {wire} does not converge, got a residual of {residual:.3g}, "
            f"expected at most {memory.tolerances[row]:.3g}"
        )
        error = FmuError(wire.partition(".")[0], message, time=self.grid.time(self.done))
        return self._outcome(FAILED, error=error)

    def _make_watch(self) -> interpreter.Watch:
        names = [p.name for p in self.ports]
        triggers, thresholds = self.director.triggers()
        return interpreter.Watch(
            record=np.array([self.program.place[n] for n in names], dtype=np.int64),
            limits=np.array([self.options.limits.get(n, np.inf) for n in names], dtype=np.float64),
            triggers=triggers,
            thresholds=thresholds,
        )

    def _read_initial_values(self) -> None:
        """Row 0, and what older values are held at until their first ones arrive."""
        values, place = self.program.values, self.program.place
        for name, instance in self.system.instances.items():
            outputs = instance.description.outputs
            for v, value in zip(outputs, self.slaves[name].get(outputs), strict=True):
                values[place[Port(name, v).name]] = value
        for wire in self.system.wires:
            source = values[place[wire.source.name]]
            values[place[wire.target.name]] = wire.conversion.factor * source + wire.conversion.offset
        self.program.fill_rings()
        self.recorder.add(values[self.watch.record][None, :])

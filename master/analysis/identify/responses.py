"""
How one FMU answers, alone, to a pulse on each input; one without inputs, to a changed start value.

All pulses start from one saved state, where the FMU has settled from its start with its inputs held. The
answer is the central difference of the runs with +delta and -delta: noise of a fixed seed and the motion
at rest cancel. Row j is the answer after step j + 1; the pulse lasts for the first step.
Limits   What no input of an FMU with inputs reaches does not show.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from master.coupling.methods.catalogue import method_of
from master.coupling.schedule import Schedule
from master.errors import FmuError
from master.fmi.description import Description, Kind, Variable
from master.fmi.saved_state import StateCall, call_state
from master.fmi.slave import Slave
from master.process import position
from master.stepping.compiler import build_program
from master.stepping.failure import failure_of
from master.stepping.machine.compiled import compiled
from master.stepping.machine.execution import execute_ticks
from master.stepping.machine.interpreter import Stop, finite_only
from master.stepping.machine.operations import is_bad
from master.stepping.simulate import SlaveFactory
from master.system.graph import Instance, Port, System

Floats = NDArray[np.float64]

N_STEPS = 640
N_SETTLING = 1000
_RELATIVE_DELTA = 1e-2
_ROUNDING = 1e-12
"""Share of the motion at rest below which a difference of two runs is rounding, and no answer."""
_SCALES = {"m": 1e-2, "m/s": 1e-1, "rad": 1e-2, "rad/s": 1e-1, "N": 1e2, "N m": 1e2}


@dataclass(frozen=True)
class Question:
    """What is asked of an FMU: which inputs and start values act on which outputs, over steps of h [s]."""

    instance: Instance
    inputs: tuple[Variable, ...]
    starts: tuple[Variable, ...]
    outputs: tuple[Variable, ...]
    held: tuple[float, ...]
    step_size: float
    t0: float

    @property
    def key(self) -> tuple[Any, ...]:
        """What the answer depends on."""
        names = tuple(v.name for v in (*self.inputs, *self.starts, *self.outputs))
        values = tuple(sorted(self.instance.start.items()))
        return (self.instance.name, self.instance.description.path, names, values, self.held, self.step_size)


@dataclass(frozen=True)
class Responses:
    """
    Answers per unit of input or start value.

    `pulses` has shape (N_STEPS, outputs, inputs), `free` (N_STEPS, outputs, starts); `curvature` is the
    part that does not change its sign with the pulse, relative to the part that does.
    """

    pulses: Floats
    free: Floats
    curvature: float


def measure(question: Question, factory: SlaveFactory) -> Responses:
    """
    Ask one FMU, from its start.

    Raises:
        FmuError: If it fails, or cannot save its state.
    """
    name, description = question.instance.name, question.instance.description
    if question.inputs and not description.can_get_and_set_state:
        raise FmuError(name, "cannot be analysed, got canGetAndSetFMUState = false, expected true")
    empty = np.empty((N_STEPS, len(question.outputs), 0))
    pulses, curvature = empty, 0.0
    if question.inputs:
        bench = Bench(question, started(question, factory))
        try:
            pulses, curvature = bench.pulses()
        finally:
            bench.close()
    free = [_free(question, v, factory)[:, :, None] for v in question.starts]
    return Responses(pulses, np.concatenate([empty, *free], 2), curvature)


def measure_running(question: Question, slave: Slave) -> Responses:
    """Ask an FMU that has come to the time `question.t0` in a run; it is left running."""
    bench = Bench(question, slave)
    try:
        slave.set(question.inputs, question.held)
        pulses, curvature = bench.pulses()
    finally:
        bench.free()
    return Responses(pulses, np.empty((N_STEPS, len(question.outputs), 0)), curvature)


def started(question: Question, factory: SlaveFactory) -> Slave:
    """Load an FMU and start it with its inputs held."""
    position.current().begin(question.t0, question.step_size)
    slave = factory(question.instance.name, question.instance.description)
    try:
        slave.enter_initialisation(question.instance.start, question.t0)
        slave.set(question.inputs, question.held)
        slave.exit_initialisation()
    except FmuError:
        slave.close(failed=True)
        raise
    return slave


def delta_of(variable: Variable) -> float:
    """Height of a pulse, small against what is usual for the unit."""
    scale = variable.nominal or _SCALES.get(variable.unit_name, 1.0)
    return _RELATIVE_DELTA * scale


def answer_of(pulse: Callable[[int, float], Floats], place: int, delta: float) -> tuple[Floats, float]:
    """
    Return the answer to a pulse per unit, shape of a run, and the share of it that bends.

    `pulse` runs with a pulse of some height on the input at a place. Differences as small as rounding are 0.
    """
    up, down, rest = pulse(place, delta), pulse(place, -delta), pulse(place, 0.0)
    odd, even = 0.5 * (up - down), 0.5 * (up + down) - rest
    scale = np.max(np.abs(odd), axis=0)
    size = np.max(np.abs(rest), axis=0) + 1e-30
    odd[:, scale <= _ROUNDING * size] = 0.0
    moved = scale > 1e-9 * size
    bent = np.max(np.abs(even), axis=0)[moved] / scale[moved]
    return odd / delta, float(np.max(bent, initial=0.0))


def _free(question: Question, variable: Variable, factory: SlaveFactory) -> Floats:
    value = float(question.instance.value_of(variable.name) or 0.0)
    delta = delta_of(variable)
    rows = []
    for changed in (value + delta, value - delta):
        start = {**question.instance.start, variable.name: changed}
        own = replace(question, instance=replace(question.instance, start=start))
        bench = Bench(own, started(own, factory))
        try:
            rows.append(bench.run(0, N_STEPS))
        finally:
            bench.close()
    answer: Floats = (rows[0] - rows[1]) / (2.0 * delta)
    return answer


class Bench:
    """One FMU at the stepping loop, with nothing connected; `values` are those of its inputs."""

    def __init__(self, question: Question, slave: Slave) -> None:
        self.question, self.slave, self.failed = question, slave, False
        self.values = list(question.held)
        instance = question.instance
        self.state = np.zeros(1, dtype=np.int64)
        schedule = Schedule.of([method_of(instance.name)], {instance.name: 1})
        system = System({instance.name: instance}, ())
        self.program = build_program(system, schedule, {instance.name: slave})
        places = [self.program.place[Port(instance.name, v).name] for v in question.outputs]
        self.monitor = finite_only(np.array(places, dtype=np.int64))

    def pulses(self) -> tuple[Floats, float]:
        """Settle, then return the answers to a pulse on each input, and how far they bend."""
        self.run(0, N_SETTLING)
        self.save()

        def pulse(place: int, delta: float) -> Floats:
            return self.pulse(place, delta, (N_SETTLING, N_SETTLING + N_STEPS))

        answers = [answer_of(pulse, i, delta_of(v)) for i, v in enumerate(self.question.inputs)]
        return np.stack([a for a, _ in answers], axis=2), max(c for _, c in answers)

    def save(self) -> None:
        """Remember the state that pulses start from."""
        self._state_call(StateCall.SAVE, self.state.ctypes.data)

    def pulse(self, place: int, delta: float, ticks: tuple[int, int]) -> Floats:
        """Run with one input raised during the first step, and go back to the saved state."""
        variable, value = self.question.inputs[place], self.values[place]
        self.slave.set([variable], [value + delta])
        first = self.run(ticks[0], ticks[0] + 1)
        self.slave.set([variable], [value])
        rows = np.concatenate([first, self.run(ticks[0] + 1, ticks[1])])
        self._state_call(StateCall.RESTORE, int(self.state[0]))
        return rows

    def run(self, begin: int, end: int) -> Floats:
        """Step; return one row of outputs for each step."""
        rows = np.empty((end - begin, len(self.monitor.record)))
        t0, h = self.question.t0, self.question.step_size
        ended = execute_ticks(compiled(), self.program, self.monitor, t0, h, begin, end, rows)
        if ended.stop == Stop.DONE:
            return rows
        name, time = self.question.instance.name, t0 + (begin + ended.ticks) * h
        self.failed = ended.stop == Stop.FAILED
        if self.failed:
            raise failure_of(self.program, {name: self.slave}, ended, time)
        message = self.slave.last_message() or "its outputs are not finite"
        raise FmuError(name, message, time=time)

    def _state_call(self, call: StateCall, argument: int) -> None:
        status = call_state(self.slave, call, argument)
        if is_bad(status) or (call is StateCall.SAVE and not self.state[0]):
            self.failed = True
            message = self.slave.last_message() or "its state cannot be saved and set"
            raise FmuError(self.question.instance.name, message)

    def free(self) -> None:
        """Return the saved state back."""
        if not self.failed and self.state[0]:
            self._state_call(StateCall.FREE, self.state.ctypes.data)

    def close(self) -> None:
        """End the FMU."""
        self.free()
        self.slave.close(failed=self.failed)


def start_variables(description: Description, start: Mapping[str, Any]) -> tuple[Variable, ...]:
    """States whose start a configuration sets."""
    given = [description.by_name[key] for key in start]
    return tuple(v for v in given if v.kind is Kind.REAL and v.causality in ("output", "local"))


def real(variables: Sequence[Variable]) -> tuple[Variable, ...]:
    """Variables that a small change makes sense for."""
    return tuple(v for v in variables if v.kind is Kind.REAL)

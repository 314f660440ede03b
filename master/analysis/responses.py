"""
How one FMU answers, alone, to a pulse on each input; one without inputs, to a changed start value.

All pulses start from one saved state, where the FMU has settled from its start with its inputs held. The
answer is the central difference of the runs with +delta and -delta: noise of a fixed seed and the motion
at rest cancel. Row j is the answer behind step j + 1; the pulse lasts for the first step.
Limits   What no input of an FMU with inputs reaches does not show.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..coupling.schedule import Schedule
from ..errors import FmuError
from ..fmi.description import Description, Kind, Variable
from ..simulation import SlaveFactory
from ..stepping import calls, loop
from ..stepping.translation import build_program
from ..system.graph import Instance, Port, System

Floats = NDArray[np.float64]

N_STEPS = 640
N_SETTLING = 1000
_RELATIVE_DELTA = 1e-2
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
        """What the answer hangs on."""
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
    Ask one FMU.

    Raises:
        FmuError: If it fails, or cannot save its state.
    """
    name, description = question.instance.name, question.instance.description
    if question.inputs and not description.can_get_and_set_state:
        raise FmuError(name, "cannot be analysed, got canGetAndSetFMUState = false, expected true")
    empty = np.empty((N_STEPS, len(question.outputs), 0))
    pulses, curvatures = [empty], [0.0]
    if question.inputs:
        bench = _Bench(question, factory)
        try:
            answers = [_answer(bench.pulse, i, _delta(v)) for i, v in enumerate(question.inputs)]
        finally:
            bench.close()
        pulses += [a[:, :, None] for a, _ in answers]
        curvatures += [c for _, c in answers]
    free = [_free(question, v, factory)[:, :, None] for v in question.starts]
    return Responses(np.concatenate(pulses, 2), np.concatenate([empty, *free], 2), max(curvatures))


def _delta(variable: Variable) -> float:
    scale = variable.nominal or _SCALES.get(variable.unit_name, 1.0)
    return _RELATIVE_DELTA * scale


def _answer(pulse: Callable[[int, float], Floats], place: int, delta: float) -> tuple[Floats, float]:
    up, down, rest = pulse(place, delta), pulse(place, -delta), pulse(place, 0.0)
    odd, even = 0.5 * (up - down), 0.5 * (up + down) - rest
    scale = np.max(np.abs(odd), axis=0)
    moved = scale > 1e-9 * (np.max(np.abs(rest), axis=0) + 1e-30)
    bent = np.max(np.abs(even), axis=0)[moved] / scale[moved]
    return odd / delta, float(np.max(bent, initial=0.0))


def _free(question: Question, variable: Variable, factory: SlaveFactory) -> Floats:
    value = float(question.instance.value_of(variable.name) or 0.0)
    delta = _delta(variable)
    rows = []
    for changed in (value + delta, value - delta):
        start = {**question.instance.start, variable.name: changed}
        bench = _Bench(replace(question, instance=replace(question.instance, start=start)), factory)
        try:
            rows.append(bench.run(0, N_STEPS))
        finally:
            bench.close()
    answer: Floats = (rows[0] - rows[1]) / (2.0 * delta)
    return answer


class _Bench:
    """One FMU at the stepping loop, with nothing connected."""

    def __init__(self, question: Question, factory: SlaveFactory) -> None:
        self.question, self.failed = question, False
        instance = question.instance
        self.slave = factory(instance.name, instance.description)
        self.state = np.zeros(1, dtype=np.int64)
        try:
            self.slave.enter_initialisation(instance.start, question.t0)
            self.slave.set(question.inputs, question.held)
            self.slave.exit_initialisation()
        except FmuError:
            self.failed = True
            self.close()
            raise
        schedule = Schedule(((instance.name,),), {instance.name: 1})
        system = System({instance.name: instance}, ())
        self.program = build_program(system, schedule, {instance.name: self.slave})
        places = [self.program.place[Port(instance.name, v).name] for v in question.outputs]
        self.record = np.array(places, dtype=np.int64)
        if question.inputs:
            self.run(0, N_SETTLING)
            self._state_call("get_state", self.state.ctypes.data)

    def pulse(self, place: int, delta: float) -> Floats:
        """Run with one input raised during the first step, and go back to the start."""
        variable, value = self.question.inputs[place], self.question.held[place]
        self.slave.set([variable], [value + delta])
        first = self.run(N_SETTLING, N_SETTLING + 1)
        self.slave.set([variable], [value])
        rows = np.concatenate([first, self.run(N_SETTLING + 1, N_SETTLING + N_STEPS)])
        self._state_call("set_state", int(self.state[0]))
        return rows

    def run(self, begin: int, end: int) -> Floats:
        """Step; give one row of outputs for each step."""
        rows = np.empty((end - begin, len(self.record)))
        n = len(self.record)
        watch = loop.Watch(self.record, np.full(n, np.inf), np.zeros((0, 2), np.int64), np.zeros((0, 2)))
        grid = (self.question.t0, self.question.step_size)
        outcome, done, _, _ = loop.compiled()(self.program.memory, watch, grid, (begin, end), rows)
        if outcome != loop.DONE:
            self.failed = outcome == loop.FAILED
            message = self.slave.last_message() or "its outputs are not finite"
            at = grid[0] + (begin + done) * grid[1]
            raise FmuError(self.question.instance.name, message, time=at)
        return rows

    def _state_call(self, name: str, argument: int) -> None:
        interface = self.slave.interface()
        if calls.state(getattr(interface, name), interface.component, argument) > loop.WARNING:
            self.failed = True
            message = self.slave.last_message() or "its state cannot be saved and set"
            raise FmuError(self.question.instance.name, message)

    def close(self) -> None:
        """End the FMU."""
        if not self.failed and self.state[0]:
            self._state_call("free_state", self.state.ctypes.data)
        self.slave.close(failed=self.failed)


def start_variables(description: Description, start: Mapping[str, Any]) -> tuple[Variable, ...]:
    """States whose start a configuration sets."""
    given = [description.by_name[key] for key in start]
    return tuple(v for v in given if v.kind is Kind.REAL and v.causality in ("output", "local"))


def real(variables: Sequence[Variable]) -> tuple[Variable, ...]:
    """Variables that a small change makes sense for."""
    return tuple(v for v in variables if v.kind is Kind.REAL)

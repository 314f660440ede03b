"""
FMUs whose answers change in the course of a run: asked at each tick, see `history`.

One that varies with time is pulsed through time. One that identifies is led through the run again by the
inputs that it had there; after each step its parameters are held, those that the step worked with, and it
is pulsed as it is: the linear system is that of the run's own parameters, and how a pulse would change
them does not enter, as it does not enter the run.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from master.analysis.state_space import StateSpace
from master.stepping.simulate import SlaveFactory

from . import history
from .declarations import departures, hold_now
from .responses import Bench, Question, delta_of, started

Floats = NDArray[np.float64]

_WHOLE = 1e-6
_SAMPLES = 20
_SAME = 1e-9


def period_of(question: Question) -> int | None:
    """Return the ticks after which an FMU answers as before; 0: constant; None: not an integer number."""
    instance = question.instance
    periods: list[int] = []
    for declared in departures(instance):
        frequency = 0.0 if declared.frequency is None else float(instance.value_of(declared.frequency) or 0.0)
        if frequency == 0.0:
            continue
        steps = 1.0 / (frequency * question.step_size)
        if abs(steps - round(steps)) >= _WHOLE * steps:
            return None
        periods.append(round(steps))
    return math.lcm(*periods) if periods else 0


def measure_through_time(question: Question, factory: SlaveFactory, ticks: int) -> Sequence[StateSpace]:
    """
    Ask an FMU in each tick from its start on.

    Raises:
        FmuError: If it fails, or cannot save its state.
    """
    bench = Bench(question, started(question, factory))
    try:
        pulses = []
        for k in range(ticks):
            pulses.append(_pulses(bench, k))
            bench.run(k, k + 1)
        return history.systems(*history.through_time(np.array(pulses)))
    finally:
        bench.close()


def measure_learning(question: Question, factory: SlaveFactory, inputs: Floats) -> Sequence[StateSpace]:
    """
    Ask an FMU that learns after each step of a run, with its parameters held.

    Args:
        question: The FMU.
        factory: Makes the slave.
        inputs: What it got in the run, shape (ticks, inputs).

    Returns:
        Nothing if it answers in the same way all along: what it learns it does not use.

    Raises:
        FmuError: If it fails, or cannot save its state.
    """
    few = _learned(question, factory, inputs, max(1, len(inputs) // _SAMPLES))
    if np.max(np.abs(few - few[0])) < _SAME * np.max(np.abs(few)):
        return ()
    return history.systems(*history.held(_learned(question, factory, inputs, 1)))


def _learned(question: Question, factory: SlaveFactory, inputs: Floats, stride: int) -> Floats:
    """Lead an FMU through a run; return its answers after each step whose number `stride` divides."""
    bench = Bench(question, started(question, factory))
    pulses = []
    try:
        for k, row in enumerate(inputs):
            bench.values = row.tolist()
            bench.slave.set(question.inputs, bench.values)
            bench.run(k, k + 1)
            if k % stride == 0:
                pulses.append(_pulses(bench, k + 1, lambda: hold_now(question.instance, bench.slave)))
        return np.array(pulses)
    finally:
        bench.close()


def _pulses(bench: Bench, k: int, prepare: Callable[[], None] = lambda: None) -> Floats:
    """Return the answers from tick k on, shape (ages, outputs, inputs), and leave the FMU as it was."""
    bench.save()
    found = []
    for i, variable in enumerate(bench.question.inputs):
        delta, rows = delta_of(variable), []
        for signed in (delta, -delta):
            prepare()
            rows.append(bench.pulse(i, signed, (k, k + history.AGES)))
        found.append((rows[0] - rows[1]) / (2.0 * delta))
    return np.stack(found, axis=2)


def alone(question: Question, factory: SlaveFactory, ticks: int) -> Floats:
    """Outputs after each step with the inputs held at their start, shape (ticks, outputs)."""
    bench = Bench(question, started(question, factory))
    try:
        return bench.run(0, ticks)
    finally:
        bench.close()


def answer(systems: Sequence[StateSpace], inputs: Floats, outputs: Floats) -> Floats:
    """Outputs after each step of a linear system in `history` coordinates, steady before the start."""
    first = systems[0]
    p, m = first.D.shape
    n = first.order // (p + m)
    x = np.concatenate([np.tile(outputs, n), np.tile(inputs, n)])
    found = np.empty((len(systems), p))
    for k, system in enumerate(systems):
        found[k] = system.C @ x + system.D @ inputs
        x = system.A @ x + system.B @ inputs
    return found

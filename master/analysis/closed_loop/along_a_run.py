"""
A system that varies with time, linearised along one of its runs.

Each FMU answers alone: once with its inputs held at their start, and to pulses, which give its linear system,
in each tick where it varies (`varying`). Coupled, these give the motion from the start on, and the map of the
total state over one period (Floquet), whose multipliers tell the growth. What the motion shows is read as it
is read of a run, by the same means and over the same time, so that the two can be compared.
Limits   An FMU that leaves the linear range in the run leaves the linear system; by how much is measured.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from master.analysis.identify.declarations import holding, learns
from master.analysis.identify.history import AGES
from master.analysis.identify.responses import Question
from master.analysis.identify.varying import alone, answer, measure_learning, measure_through_time, period_of
from master.evaluation.modes import Mode, dominant_mode
from master.recording.recorder import Result
from master.stepping.outcome import RunOptions
from master.stepping.simulate import simulate

from .linearise import Linearisation
from .tick_matrix import LinearPart, LinearSystem, TickPropagation

Floats = NDArray[np.float64]
Rows = Mapping[str, Floats]

SHOWN_DEPARTURE = 1e-2


@dataclass(frozen=True)
class LinearityAlongRun:
    """
    What a run shows if its FMUs are linear, from `begin` to `end` [s].

    `mode`: of the compared signal; `reference`: of its reference; `simulated`: of the run itself. `growths`:
    of the fastest multiplier over each whole `period` [s], in 1/s; one if all periods are equal. `departure`:
    of the linear motion from that of the run, over the largest motion; `nonlinear`: the FMU that departs
    most, led as in the run, and by how much. `learners`: FMUs whose answers the run has changed.
    """

    begin: float
    end: float
    mode: Mode | None
    reference: Mode | None
    simulated: Mode | None
    period: float | None
    growths: tuple[float, ...]
    departure: float
    nonlinear: tuple[str, float] | None
    learners: tuple[str, ...]


def linearity_along_run(linearisation: Linearisation, frozen: LinearSystem) -> LinearityAlongRun | None:
    """
    Linearise along a run; None where no FMU varies with time, or where they step at several rates.

    Raises:
        FmuError: If an FMU fails, or cannot save its state.
    """
    system = linearisation.experiment.system
    asked = {name: linearisation.question(system, instance) for name, instance in system.instances.items()}
    periods = {name: period_of(question) if question.inputs else 0 for name, question in asked.items()}
    if frozen.period != 1 or not any(p != 0 for p in periods.values()):
        return None
    result = _run(linearisation)
    held = {w.target.name: w.conversion.of(float(result[w.source.name][0])) for w in system.wires}
    questions = {
        name: replace(q, held=tuple(held[f"{name}.{v.name}"] for v in q.inputs)) for name, q in asked.items()
    }
    return _CoupledRun(linearisation, frozen, result, questions, periods).judged()


def _run(linearisation: Linearisation) -> Result:
    e = linearisation.experiment
    options = RunOptions(limits=e.limits, inputs=e.inputs)
    outcome = simulate(e.system, e.schedule, e.grid, options=options, factory=linearisation.factory)
    if outcome.error is not None:
        raise outcome.error
    return outcome.result


class _Motion(TickPropagation):
    """Deviations from the start in numbers; `forced` outputs stand in place of those of the linear FMUs."""

    def __init__(self, coupled: LinearSystem, nominal: Rows, forced: Rows | None = None) -> None:
        super().__init__(coupled, np.zeros((len(coupled.owners()), 1)))
        self.nominal, self.forced = nominal, forced
        self.answers: dict[str, list[Floats]] = {name: [] for name in coupled.parts}
        self.inputs: dict[str, list[list[float]]] = {name: [] for name in coupled.parts}

    def _step(self, name: str, width: int) -> None:
        self.inputs[name].append([float(self.signals[i][0]) for i in self.coupled.parts[name].inputs])
        super()._step(name, width)
        found = self.held[name]
        found[:, 0] += self.nominal[name][self.tick]
        self.answers[name].append(found[:, 0])
        if self.forced is not None:
            self.held[name] = np.zeros_like(found)
            self.held[name][:, 0] = self.forced[name][self.tick]

    def over(self, ticks: int) -> _Motion:
        for k in range(ticks):
            self.run(k)
        return self


class _CoupledRun:
    """A run, its FMUs made linear and coupled, and what each does with its inputs held at the start."""

    def __init__(
        self,
        linearisation: Linearisation,
        frozen: LinearSystem,
        result: Result,
        questions: Mapping[str, Question],
        periods: Mapping[str, int | None],
    ) -> None:
        self.linearisation, self.frozen, self.result = linearisation, frozen, result
        self.questions, self.periods = questions, periods
        self.ticks = len(result.time) - 1
        self.start = {n: np.array([result[o][0] for o in p.outputs]) for n, p in frozen.parts.items()}
        self.moved = {name: self._recorded(part) - self.start[name] for name, part in frozen.parts.items()}
        self.learners: list[str] = []
        self.nominal: dict[str, Floats] = {}
        parts = {name: self._part(name, part) for name, part in frozen.parts.items()}
        self.coupled = replace(frozen, system=linearisation.experiment.system, parts=parts)

    def _recorded(self, part: LinearPart) -> Floats:
        """Outputs behind each step, shape (ticks, outputs)."""
        return np.array([self.result[name][1:] for name in part.outputs]).reshape(-1, self.ticks).T

    def _part(self, name: str, part: LinearPart) -> LinearPart:
        question, period, factory = self.questions[name], self.periods[name], self.linearisation.factory
        if learns(question.instance):
            inputs = self._inputs(name) + np.array(question.held)
            if systems := measure_learning(question, factory, inputs):
                self.learners.append(name)
                start = self.start[name]
                self.nominal[name] = answer(systems, np.array(question.held), start) - start
                return replace(part, system=systems[0], systems=systems)
            question = replace(question, instance=holding(question.instance))
        self.nominal[name] = alone(question, factory, self.ticks) - self.start[name]
        if period != 0:
            ticks = self.ticks if period is None else period + AGES
            systems = measure_through_time(question, factory, ticks)
            return replace(part, system=systems[0], systems=systems, repeats=period or 1)
        return part

    def _inputs(self, name: str) -> Floats:
        """Inputs of an FMU in the run, less those at the start, shape (ticks, inputs)."""
        nothing = {n: np.zeros_like(rows) for n, rows in self.moved.items()}
        return np.array(_Motion(self.frozen, nothing, self.moved).over(self.ticks).inputs[name])

    def judged(self) -> LinearityAlongRun:
        """Read motion, growth and departure."""
        mode, reference, simulated, departure = self._motions()
        period, growths = self._growths()
        nonlinear = self._nonlinear() if departure > SHOWN_DEPARTURE else None
        return LinearityAlongRun(
            begin=float(self.result.time[0]),
            end=float(self.result.time[-1]),
            mode=mode,
            reference=reference,
            simulated=simulated,
            period=period,
            growths=growths,
            departure=departure,
            nonlinear=nonlinear,
            learners=tuple(self.learners),
        )

    def _motions(self) -> tuple[Mode | None, Mode | None, Mode | None, float]:
        compare = self.linearisation.experiment.compare_in_fmus
        if compare is None:
            return None, None, None, 0.0
        name, step = compare.signal.instance, self.coupled.step_size
        place = self.coupled.parts[name].outputs.index(compare.signal)
        answers = np.array(_Motion(self.coupled, self.nominal).over(self.ticks).answers[name])
        motion, run = np.concatenate([[0.0], answers[:, place]]), self.result[compare.signal]
        named = None if compare.reference is None else self.result[compare.reference]
        reference = None if named is None else dominant_mode(named, step)
        departure = _relative(motion, run - run[0])
        return dominant_mode(motion + run[0], step), reference, dominant_mode(run, step), departure

    def _nonlinear(self) -> tuple[str, float]:
        led = _Motion(self.coupled, self.nominal, self.moved).over(self.ticks)
        found = {
            name: max(map(_relative, np.array(rows).T, self.moved[name].T), default=0.0)
            for name, rows in led.answers.items()
        }
        return max(found.items(), key=lambda item: item[1])

    def _growths(self) -> tuple[float | None, tuple[float, ...]]:
        """Period [s], and growth of the fastest multiplier over each that is whole [1/s]."""
        steps = list(self.periods.values())
        if any(p is None for p in steps):
            return None, ()
        period = math.lcm(*(p for p in steps if p))
        count = max(0, (self.ticks - AGES) // period) if self.learners else 1
        seconds, found = period * self.coupled.step_size, []
        for j in range(count):
            multipliers = np.linalg.eigvals(self.coupled.matrix(AGES + j * period, period))
            found.append(math.log(max(float(np.max(np.abs(multipliers))), 1e-300)) / seconds)
        return seconds, tuple(found)


def _relative(found: Floats, run: Floats) -> float:
    largest = float(np.max(np.abs(run), initial=0.0))
    return float(np.max(np.abs(found - run), initial=0.0)) / largest if largest > 0.0 else 0.0

"""From an experiment to its linear system: which FMU is asked what; answers are kept."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from typing import Any

from master.analysis.identify.declarations import departures, learning_of, learns
from master.analysis.identify.online_identifiers import measure_learned
from master.analysis.identify.realisation import realise
from master.analysis.identify.responses import Question, Responses, measure, real, start_variables
from master.analysis.state_space import StateSpace
from master.experiment.experiment import Experiment
from master.fmi.description import Kind
from master.fmi.values import parse
from master.stepping.simulate import SlaveFactory, load, simulate
from master.system.graph import Instance, System
from master.text.scalar import Plain
from master.text.signal_name import SignalName

from .tick_matrix import LinearPart, LinearSystem

WHEN_HELD = "learning is not linear: what the FMU has learned stays as a run leaves it"


@dataclass(frozen=True)
class Assumption:
    """A value that the analysis sets, because the system is not linear or constant with its own."""

    signal: str
    value: str | float
    reason: str


@dataclass
class Linearisation:
    """
    Measures each FMU alone, once for each set of parameters, and couples the linear systems.

    `after_run`: an FMU that learns is asked as a run leaves it, not with its assumed parameters.
    """

    experiment: Experiment
    factory: SlaveFactory = load
    after_run: bool = False
    system: System = field(init=False)
    assumptions: tuple[Assumption, ...] = field(init=False)
    _known: dict[Any, StateSpace] = field(default_factory=dict)
    _held: dict[str, float] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self.system, self.assumptions = frozen(self.experiment.system, after_run=self.after_run)
        self.assumptions += tuple(_held_inputs(self.experiment))
        self._held = self._initial_inputs()

    def coupled(
        self, changes: Mapping[str, float] | None = None, extra: Mapping[str, int] | None = None
    ) -> LinearSystem:
        """
        Return the coupled system.

        Args:
            changes: Parameters by `instance.parameter` that differ from the experiment's.
            extra: Whole ticks of delay by the target of a connection.
        """
        system = changed(self.system, changes or {})
        parts = {name: self._part(system, instance) for name, instance in system.instances.items()}
        schedule, step = self.experiment.schedule, self.experiment.grid.step_size
        return LinearSystem(system, schedule, parts, step, extra or {})

    def question(self, system: System, instance: Instance) -> Question:
        """Say what is asked of an FMU: its connected inputs, and the outputs that are used."""
        name, description = instance.name, instance.description
        wires = [w for w in system.wires_into(name) if w.source.variable.kind is Kind.REAL]
        inputs = real([w.target.variable for w in wires])
        used = {w.source.variable.name for w in system.wires if w.source.instance == name}
        used |= {SignalName(s).variable for s in self._watched() if s.startswith(f"{name}.")}
        outputs = real([v for v in description.outputs if v.name in used])
        return Question(
            instance=instance,
            inputs=inputs,
            starts=start_variables(description, instance.start) if outputs and not inputs else (),
            outputs=outputs,
            held=tuple(self._held[f"{name}.{v.name}"] for v in inputs),
            step_size=self.experiment.grid.step_size * instance.every,
            t0=self.experiment.grid.t0,
        )

    def _part(self, system: System, instance: Instance) -> LinearPart:
        question = self.question(system, instance)
        if question.key not in self._known:
            self._known[question.key] = realise(self._measured(question))
        groups = (question.inputs, question.outputs)
        inputs, outputs = (tuple(f"{instance.name}.{v.name}" for v in group) for group in groups)
        return LinearPart(self._known[question.key], inputs, outputs)

    def _measured(self, question: Question) -> Responses:
        if self.after_run and learns(question.instance):
            return measure_learned(question, self.experiment, self.system, self.factory)
        return measure(question, self.factory)

    def _watched(self) -> list[str]:
        compare = self.experiment.compare_in_fmus
        if compare is None:
            return []
        return [s for s in (compare.signal, compare.reproduced, compare.reference) if s is not None]

    def _initial_inputs(self) -> dict[str, float]:
        """Values that the inputs have at the start of a run."""
        system = self.system
        grid = replace(self.experiment.grid, n_ticks=0)
        start = simulate(system, self.experiment.schedule, grid, factory=self.factory).result
        return {w.target.name: w.conversion.of(float(start[w.source.name][0])) for w in system.wires}


def _held_inputs(experiment: Experiment) -> Iterator[Assumption]:
    """A recording drives a system and is no part of its loops: its inputs keep their first values."""
    inputs = experiment.inputs
    if inputs.values is not None:
        for feed, value in zip(inputs.feeds, inputs.values[0].tolist(), strict=True):
            yield Assumption(feed.target, value, f"first value of the recording {feed.source}")


def frozen(system: System, *, after_run: bool) -> tuple[System, tuple[Assumption, ...]]:
    """Make linear and constant what the FMUs declare is not; return the system and what is assumed."""
    found = []
    for name, instance in system.instances.items():
        learning = learning_of(instance) if after_run else None
        if learning is not None:
            found.append(Assumption(f"{name}.{learning.held_by}", "true", WHEN_HELD))
        for declared in departures(instance):
            if learning is not None and declared.parameter == learning.by:
                continue
            variable = instance.description.by_name[declared.parameter]
            value = float(parse(variable, Plain(declared.value)))
            is_number = variable.kind in (Kind.REAL, Kind.INTEGER) and not variable.items
            signal = f"{name}.{declared.parameter}"
            found.append(Assumption(signal, value if is_number else declared.value, declared.reason))
            system = changed(system, {signal: value})
    return system, tuple(found)


def without_reference(experiment: Experiment) -> Experiment:
    """Leave the reference out that no wire needs: it is in no loop."""
    compare = experiment.config.compare
    if compare is None or compare.reference is None:
        return experiment
    config = experiment.config.model_copy(
        update={"compare": compare.model_copy(update={"reference": None, "reference_force": None})}
    )
    return replace(experiment, config=config)


def changed(system: System, changes: Mapping[str, float]) -> System:
    """Replace parameters by `instance.parameter`."""
    instances = dict(system.instances)
    for signal, value in changes.items():
        name, key = SignalName(signal).parts
        instances[name] = replace(instances[name], start={**instances[name].start, key: value})
    return replace(system, instances=instances)

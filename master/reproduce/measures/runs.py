"""One run of the paper's system: what is run, and what is kept of it."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from master.api import prepare_to_run
from master.catalogue import Progress, silent
from master.coupling.schedule import make_schedule
from master.experiment.experiment import Experiment
from master.experiment.prepare import Request
from master.fmi.values import parse
from master.installation import CONFIG_FOLDER
from master.stepping.outcome import RunOptions
from master.stepping.simulate import simulate
from master.system.graph import System
from master.text.signal_name import SignalName

from .measures import MEASURES, Trace

Floats = NDArray[np.float64]
Order = tuple[str | tuple[str, ...], ...]

SEED = "force_sensor.seed"


@dataclass(frozen=True)
class Run:
    """A configuration with a variant, `instance.parameter=value` over it, seed, stop time [s] and order."""

    config: str
    variant: str | None = None
    values: tuple[str, ...] = ()
    seed: int = 1
    stop_time: float | None = None
    order: Order | None = None

    def with_seed(self, seed: int) -> Run:
        """Return the same run with another noise."""
        return replace(self, seed=seed)


@dataclass(frozen=True)
class Wanted:
    """What shall be kept of a run: numbers by the name of their measure, and whole signals."""

    measures: frozenset[str] = frozenset()
    signals: frozenset[str] = frozenset()

    def __or__(self, other: Wanted) -> Wanted:
        return Wanted(self.measures | other.measures, self.signals | other.signals)


@dataclass(frozen=True)
class Recording:
    """What was kept; a number is NaN where the run has none, as a frequency without oscillation."""

    status: str
    numbers: Mapping[str, float]
    time: Floats
    signals: Mapping[str, Floats] = field(default_factory=dict)

    def __getitem__(self, signal: str) -> Floats:
        return self.signals[signal]


def experiment_of(run: Run, progress: Progress = silent) -> Experiment:
    """Prepare a run."""
    base = _prepared(run.config, run.variant, run.values, run.stop_time, progress)
    system = _seeded(base.system, run.seed)
    schedule = base.schedule if run.order is None else make_schedule(system, _listed(run.order), "order")
    return replace(base, system=system, schedule=schedule)


def perform(run: Run, wanted: Wanted) -> Recording:
    """Step a run and keep what is wanted."""
    experiment = experiment_of(run)
    options = RunOptions(
        limits=experiment.limits,
        compared=experiment.compared,
        scenario=experiment.scenario,
        inputs=experiment.inputs,
    )
    outcome = simulate(experiment.system, experiment.schedule, experiment.grid, options=options)
    result = outcome.result
    trace = Trace(experiment, result)
    numbers = {name: _number(MEASURES[name](trace)) for name in sorted(wanted.measures)}
    signals = {name: result[name].copy() for name in sorted(wanted.signals)}
    return Recording(outcome.status, numbers, result.time, signals)


@cache
def _prepared(
    config: str, variant: str | None, values: tuple[str, ...], stop_time: float | None, progress: Progress
) -> Experiment:
    path = CONFIG_FOLDER / f"{config}.yaml"
    return prepare_to_run(path, Request(variant, values, stop_time), progress)


def _seeded(system: System, seed: int) -> System:
    name, key = SignalName(SEED).parts
    if name not in system.instances:
        return system
    instance = system.instances[name]
    value = parse(instance.description.by_name[key], seed)
    changed = replace(instance, start={**instance.start, key: value})
    return replace(system, instances={**system.instances, name: changed})


def _listed(order: Order) -> list[Any]:
    return [list(entry) if isinstance(entry, tuple) else entry for entry in order]


def _number(value: float | None) -> float:
    return math.nan if value is None else float(value)

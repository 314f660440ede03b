"""
Runs of the benchmark: a method on a building, under a ground motion, on the nominal plant or a perturbed one.

A method and its league name a configuration of `configs/rths`; the case is a variant of it. In the
league `displacement` a method changes the command alone, as the rules of the benchmark ask; in `force` the
force too.
"""

from __future__ import annotations

import copy
from contextlib import closing
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from master.api import prepare_to_run
from master.catalogue import Progress, parameters, silent
from master.errors import ConfigError
from master.experiment.experiment import Experiment
from master.experiment.prepare import Request
from master.installation import configuration
from master.runs.kept_runs import KeptRuns
from master.stepping.outcome import COMPLETED
from master.system.config import Config, LoadedConfig
from master.system.inputs import Feed, MeasuredInputs, with_first_values
from master.text.validation import validate
from master.text.yaml_lines import Document, read_yaml

from .measures import Motions, measures, spread_of
from .record import Record

FORCE = "force"
DISPLACEMENT = "displacement"
CONFIGURATIONS = {
    ("sample", DISPLACEMENT): "rths/sample",
    ("inverse3", DISPLACEMENT): "rths/inverse3",
    ("amb", DISPLACEMENT): "rths/amb",
    ("robust", FORCE): "rths/robust",
    ("robust", DISPLACEMENT): "rths/robust_displacement",
}
METHODS = tuple(dict.fromkeys(method for method, _ in CONFIGURATIONS))
CASES = (1, 2, 3, 4)
CLOSED_FORM = "closed form"
"""Name of the ground motion of the configurations."""

GROUND = "ground"
DRIVEN = ("building.a_g", "reference.a_g")
DEVIATIONS = {"k_e": 50e3, "b_1": 3.3, "b_2": 3.3e3, "a_3": 1.3}
"""Standard deviations of the perturbed plants [N/m, 1/s, 1/s2, 1/s]; the whole building stays."""
OF_THE_SPECIMEN = "k_e"
"""Parameter that the numerical part shares with the plant."""


@dataclass(frozen=True)
class Benchmark:
    """What is run: method, league and case, a record or the closed form, with noise or without."""

    method: str
    league: str
    case: int
    record: Record | None
    with_noise: bool

    @property
    def record_name(self) -> str:
        """Name of the ground motion."""
        return CLOSED_FORM if self.record is None else self.record.name


@dataclass(frozen=True)
class Score:
    """
    J1 [ms], J2 to J9 [%], None unless the run completed; parameters of the plant that are not nominal.

    `floor`: what the noise of the transducer alone makes of J4 [%].
    """

    J: list[float] | None
    floor: float | None
    plant: dict[str, float]
    status: str


def leagues(method: str) -> list[str]:
    """Return the leagues that a method has a configuration for, the first one by default."""
    return [league for name, league in CONFIGURATIONS if name == method]


def perturbed(nominal: dict[str, float], seed: int) -> dict[str, float]:
    """Draw the parameters of a plant around the nominal ones."""
    drawn = np.random.default_rng(seed).standard_normal(len(DEVIATIONS))
    return {
        name: nominal[name] + deviation * float(n)
        for (name, deviation), n in zip(DEVIATIONS.items(), drawn, strict=True)
    }


def score(task: Benchmark, seed: int, progress: Progress = silent) -> Score:
    """
    Run a task; seed 0 is the nominal plant, the others are perturbed ones. The noise has seed + 1.

    Raises:
        ConfigError: If the configuration is wrong.
        FmuError: If an FMU fails.
    """
    with closing(KeptRuns()) as runs:
        return next_score(runs, task, seed, progress)


def next_score(runs: KeptRuns, task: Benchmark, seed: int, progress: Progress = silent) -> Score:
    """Run a task as `score` does; `runs` keeps the FMUs loaded from one plant to the next."""
    plant = {} if seed == 0 else perturbed(_nominal(task), seed)
    experiment = _prepared(task, plant, seed + 1, progress)
    step_size = experiment.grid.step_size
    inputs = _inputs(task, step_size)
    system = with_first_values(experiment.system, inputs)
    outcome = runs.run(replace(experiment, system=system, inputs=inputs))
    if outcome.error is not None:
        raise outcome.error
    if outcome.status != COMPLETED:
        return Score(None, None, plant, outcome.status)
    result = outcome.result
    motions = Motions(
        floors=np.column_stack([result[f"building.x{i}"] for i in (1, 2, 3)]),
        measured=result["sensor.x_mea"],
        reference=np.column_stack([result[f"reference.x{i}"] for i in (1, 2, 3)]),
    )
    floor = spread_of(motions.measured - result["actuator.x"], motions.reference[:, 0])
    return Score(measures(motions, step_size), floor, plant, outcome.status)


def _nominal(task: Benchmark) -> dict[str, float]:
    """Return the parameters of the actuator that are perturbed, as its model has them."""
    entry = _document(task)["fmus"]["actuator"]
    return {**parameters(entry["source"]), **(entry.get("parameters") or {})}


def _document(task: Benchmark) -> dict[str, Any]:
    path = configuration(CONFIGURATIONS[task.method, task.league])
    document: dict[str, Any] = copy.deepcopy(read_yaml(path).data)
    if task.record is None:
        return document
    del document["fmus"][GROUND]
    document["coupling"]["order"].remove(GROUND)
    document["connections"] = [
        wire for wire in document["connections"] if not wire["from"].startswith(f"{GROUND}.")
    ]
    h = float(document["step_size"])
    document["stop_time"] = task.record.n_ticks(h) * h
    return document


def _prepared(task: Benchmark, plant: dict[str, float], noise_seed: int, progress: Progress) -> Experiment:
    path = configuration(CONFIGURATIONS[task.method, task.league])
    found = validate(Config, Document(path, _document(task)), "system")
    if found.model is None:
        raise ConfigError(found.problems)
    values = {f"actuator.{name}": value for name, value in plant.items()}
    if OF_THE_SPECIMEN in plant:
        values[f"building.{OF_THE_SPECIMEN}"] = plant[OF_THE_SPECIMEN]
    values["sensor.seed"] = noise_seed
    if not task.with_noise:
        values |= dict.fromkeys(("sensor.sigma_x", "sensor.sigma_f", "sensor.quantum_x"), 0.0)
    assignments = tuple(f"{signal}={value!r}" for signal, value in values.items())
    request = Request(variant=f"case_{task.case}", assignments=assignments)
    return prepare_to_run(LoadedConfig(found.model, found.document, found.problems), request, progress)


def _inputs(task: Benchmark, step_size: float) -> MeasuredInputs:
    """Return the record as what drives building and reference; nothing for the closed form."""
    if task.record is None:
        return MeasuredInputs()
    values = task.record.at_ticks(step_size)
    feeds = tuple(Feed(task.record.name, target) for target in DRIVEN)
    return MeasuredInputs(feeds, np.column_stack([values] * len(feeds)))

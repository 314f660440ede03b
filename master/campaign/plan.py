"""A campaign that is ready to run: all that is wrong with it has been said, no FMU has been loaded."""

from __future__ import annotations

import hashlib
import json
import shlex
from collections import Counter
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from master.api import prepare_to_run
from master.catalogue import Progress, silent
from master.errors import ConfigError, Problem, nearest
from master.evaluation.metrics import UNITS
from master.experiment.experiment import Experiment
from master.experiment.prepare import Request, read_system
from master.fmi.units import Unit
from master.fmi.values import named_by
from master.installation import configuration
from master.stepping.recorded import recorded_ports
from master.system.graph import signal_fault, with_values
from master.text.yaml_lines import Document

from .campaign import ALL, Campaign, Design, Measure, Vary, read_campaign
from .measures import load_function
from .sample import Column, Sample, make_sample
from .systems import Varied, prepared
from .target import Target, target

OUTCOME = ("run", "status", "message", "seed", "wall_s", "stepping_s", "t_end", "steps")
"""Columns of the dataset that each campaign has, before the inputs and the measures."""

DIVERGED_SHARE = "diverged"
"""What `until` and `tune` may name next to numbers of a run: whether it diverged, 0 or 1."""

_MOST_CHECKED = 200  # values of one key whose systems are prepared before the first run


@dataclass(frozen=True)
class Plan:
    """
    What is run, and what is kept of it.

    `document` is the campaign's file and `folder` its folder; `source` is the system as the campaign names
    it, for commands that repeat runs; `signals` maps signals to n, each n-th row is kept.
    """

    campaign: Campaign
    document: Document
    source: str
    folder: Path
    varied: Varied
    sample: Sample
    metrics: tuple[str, ...]
    signals: Mapping[str, int]

    @property
    def name(self) -> str:
        """Name of the campaign: its own, or that of the system."""
        return self.campaign.name or self.varied.base.title

    @property
    def base(self) -> Experiment:
        """System as it is where nothing varies."""
        return self.varied.base

    @property
    def measures(self) -> Mapping[str, Measure]:
        """The campaign's own measures."""
        return self.campaign.keep.measures

    @property
    def numbers(self) -> tuple[str, ...]:
        """Names of the numbers of a run: metrics, then measures."""
        return (*self.metrics, *self.measures)

    @cached_property
    def units(self) -> dict[str, str]:
        """Units of inputs, numbers and signals."""
        system = self.base.system
        own = {name: _unit_of_measure(measure, self) for name, measure in self.measures.items()}
        return {
            **{column.key: column.unit for column in self.sample.columns},
            **{name: UNITS.get(name, "1") for name in self.metrics},
            **own,
            **{name: system.port(name).variable.unit_name for name in self.signals},
        }

    @cached_property
    def digest(self) -> str:
        """Digest of all that decides what the runs compute, and of what is kept of them."""
        campaign = self.campaign.model_dump(mode="json", exclude={"until", "time_limit", "description"})
        parts = [json.dumps(campaign, sort_keys=True, default=str)]
        parts += [json.dumps(self.varied.loaded.document.data, sort_keys=True, default=str)]
        files = {i.description.path for i in self.base.system.instances.values()} | set(
            self.base.inputs.files.values()
        )
        parts += sorted(hashlib.sha256(path.read_bytes()).hexdigest() for path in files if path.is_file())
        return hashlib.sha256("\0".join(parts).encode()).hexdigest()

    def values(self, run: int) -> dict[str, Any]:
        """Return the values of a run of the sample, by key."""
        return self.sample.values(run)

    def grid(self, values: Mapping[str, list[Any]]) -> Sample:
        """
        Return all combinations of some numbers, by key, in the units of the system.

        What is linked to others follows; all else has its middle value, or the one that it has most often.

        Raises:
            ConfigError: If the links do not bear it.
        """
        vary = dict(self.campaign.vary)
        for column in self.sample.free:
            vary[column.key] = Vary(values=values.get(column.key) or [_middle(column)])
        campaign = self.campaign.model_copy(
            update={"vary": vary, "design": Design(), "correlations": []},
        )

        def where(*place: str | int) -> str:
            return self.document.where(place)

        return make_sample(campaign, self.varied.targets, where, _Base(self.base))

    def seed_of(self, values: Mapping[str, Any]) -> int | None:
        """Return the seed of the noise in a run: the one that varies, or the one seed that the system has."""
        own = [v for k, v in values.items() if k.rpartition(".")[2] == "seed"]
        if not own:
            found = (i.value_of("seed") for i in self.base.system.instances.values())
            own = [value for value in found if value is not None]
        return int(own[0]) if len(own) == 1 else None

    def command(self, run: int, file: str) -> str:
        """
        Return the command that repeats a run.

        Args:
            run: Its number.
            file: Where the system of a run is written whose structure varies.
        """
        values = self.values(run)
        structural = any(self.varied.targets[key].place for key in values)
        plain = {k: v for k, v in values.items() if not self.varied.targets[k].place}
        campaign = self.campaign
        given: dict[str, Any] = {str(signal): value for signal, value in campaign.set.items()}
        given |= self.varied.settings(plain)
        parts = ["dockloop", "run", file if structural else self.source]
        parts += [] if campaign.variant is None else ["--variant", campaign.variant]
        parts += [] if campaign.stop_time is None else ["--stop-time", repr(campaign.stop_time)]
        parts += [] if campaign.step_size is None else ["--step-size", repr(campaign.step_size)]
        parts += [] if campaign.flavour == "native" else ["--flavour", campaign.flavour]
        for signal, value in given.items():
            parts += ["--set", f"{signal}={_as_text(value)}"]
        return shlex.join(parts)

    def needs_file(self, run: int) -> bool:
        """Whether the command that repeats a run needs a file of its system."""
        return any(self.varied.targets[key].place for key in self.values(run))


def _as_text(value: Any) -> str:
    return str(value) if isinstance(value, str) else json.dumps(value)


def make_plan(path: Path, progress: Progress = silent) -> Plan:
    """
    Read and check a campaign.

    Raises:
        ConfigError: With every fault of the campaign, of its system, and of values that do not fit.
    """
    campaign, document = read_campaign(path)
    return plan_of(campaign, document, progress)


def plan_of(campaign: Campaign, document: Document, progress: Progress = silent) -> Plan:
    """Check a campaign that has been read, as `make_plan` does; `document` names places in messages."""
    return _Planner(campaign, document, progress).plan()


class _Planner:
    """The stages of a plan; each adds its faults."""

    def __init__(self, campaign: Campaign, document: Document, progress: Progress) -> None:
        self.campaign = campaign
        self.document = document
        self.progress = progress
        self.folder = document.path.parent
        self.problems: list[Problem] = []

    def plan(self) -> Plan:
        own = self.folder / self.campaign.system
        source = own if own.is_file() else configuration(self.campaign.system)
        request = Request(
            variant=self.campaign.variant,
            assignments=tuple(f"{signal}={_as_text(v)}" for signal, v in self.campaign.set.items()),
            stop_time=self.campaign.stop_time,
            step_size=self.campaign.step_size,
            flavour=self.campaign.flavour,
        )
        try:
            loaded = read_system(source, request)
            base = prepare_to_run(loaded, request, self.progress)
        except ConfigError as error:
            raise ConfigError(map(self._here, error.problems)) from None
        varied = Varied(loaded, request, base, self._targets(loaded, base))
        signals = self._signals(base)
        self._check_measures(base)
        if self.problems:
            raise ConfigError(self.problems)
        sample = make_sample(self.campaign, varied.targets, self._where, _Base(base))
        metrics = () if base.compare is None else tuple(self.campaign.keep.metrics)
        shown = str(own) if own.is_file() else self.campaign.system
        plan = Plan(self.campaign, self.document, shown, self.folder, varied, sample, metrics, signals)
        self._check_names(plan)
        for column in sample.columns:
            self._check_values(varied, column)
        self._check_tune(varied)
        if self.problems:
            raise ConfigError(self.problems)
        return plan

    def _where(self, *place: str | int) -> str:
        return self.document.where(place)

    def _add(self, problem: Problem, *place: str | int) -> None:
        self.problems.append(problem.at(self._where(*place)))

    def _here(self, problem: Problem) -> Problem:
        """Name the campaign's key instead of the option that `dockloop run` has for it."""
        keys: dict[str, tuple[str, ...]] = {
            "--variant": ("variant",),
            "--stop-time": ("stop_time",),
            "--step-size": ("step_size",),
        }
        option, _, signal = problem.where.partition(" ")
        place = ("set", signal.partition(":")[0]) if option == "--set" and signal else keys.get(option)
        if place is None:
            return problem
        return Problem(problem.what, where=self._where(*place), got=problem.got, expected=problem.expected)

    def _targets(self, loaded: Any, base: Experiment) -> dict[str, Target]:
        found: dict[str, Target] = {}
        tuned = () if self.campaign.tune is None else tuple(self.campaign.tune.values)
        for section, keys in (("vary", tuple(self.campaign.vary)), ("tune", tuned)):
            for key in keys:
                try:
                    found[key] = target(key, loaded, base)
                except ValueError as error:
                    place = (section, key) if section == "vary" else (section, "values", key)
                    self._add(error.args[0], *place)
                    continue
                self._check_sources(found[key], base, key, section)
        if "seed" in found:  # those that vary by themselves keep their own
            own = tuple(s for s in found["seed"].signals if s not in found)
            found["seed"] = Target("seed", signals=own, is_structural=found["seed"].is_structural)
        return found

    def _check_sources(self, found: Target, base: Experiment, key: str, section: str) -> None:
        for signal in found.signals:
            if signal in self.campaign.set:
                self._add(Problem("is given twice", expected="one of set and vary"), "set", signal)
            if signal in base.inputs.columns:
                self._add(Problem("is driven by a recording", expected="another signal"), section, key)

    def _signals(self, base: Experiment) -> dict[str, int]:
        known = [port.name for port in recorded_ports(base.system)]
        given = dict(self.campaign.keep.signals)
        every = given.pop(ALL, None)
        for signal in given:
            self._check_output(base, known, signal, "keep", "signals", signal)
        return {**({} if every is None else dict.fromkeys(known, every)), **given}

    def _check_output(self, base: Experiment, known: Iterable[str], signal: str, *place: str) -> None:
        if signal not in known:
            fault = signal_fault(base.system.descriptions, signal, ("output",))
            expected = nearest(signal, known)
            self._add(fault or Problem("no such output", got=repr(signal), expected=expected), *place)

    def _check_measures(self, base: Experiment) -> None:
        known = [port.name for port in recorded_ports(base.system)]
        for name, measure in self.campaign.keep.measures.items():
            for signal in measure.signals:
                self._check_output(base, known, signal, "keep", "measures", name)
            if measure.function is not None:
                try:
                    load_function(measure.function, self.folder)
                except ConfigError as error:
                    for problem in error.problems:
                        self._add(problem, "keep", "measures", name, "function")

    def _check_names(self, plan: Plan) -> None:
        taken = {*OUTCOME, DIVERGED_SHARE, *plan.metrics, *self.campaign.vary}
        for name in self.campaign.keep.measures:
            if name in taken:
                expected = "a name that is not taken"
                self._add(
                    Problem("name of another column", got=repr(name), expected=expected),
                    "keep",
                    "measures",
                    name,
                )
        known = (DIVERGED_SHARE, *plan.numbers)
        until = self.campaign.until
        tune = self.campaign.tune
        named: list[tuple[str, tuple[str | int, ...]]] = []
        named += [] if until is None else [(until.measure, ("until", "measure"))]
        named += [] if tune is None else [(tune.minimise, ("tune", "minimise"))]
        for i, constraint in enumerate(() if tune is None else tune.constraints):
            named.append((constraint.measure, ("tune", "constraints", i, "measure")))
        for name, place in named:
            if name not in known:
                self._add(Problem("no such measure", got=repr(name), expected=nearest(name, known)), *place)

    def _check_values(self, varied: Varied, column: Column) -> None:
        """Try the values of a column: all of a short list, the ends of a long one."""
        values = _extremes(column)
        for value in values:
            given = {column.key: value}
            try:
                if column.target.is_structural:
                    prepared(varied, given)
                else:
                    with_values(varied.base.system, varied.settings(given))
            except ConfigError as error:
                for problem in error.problems:
                    self._add(problem, "vary", column.key)
                return

    def _check_tune(self, varied: Varied) -> None:
        if self.campaign.tune is None:
            return
        for key, bounds in self.campaign.tune.values.items():
            if key in self.campaign.vary:
                self._add(Problem("varies already", expected="one of vary and tune"), "tune", "values", key)
            for value in bounds:
                try:
                    with_values(varied.base.system, varied.settings({key: value}))
                except ConfigError as error:
                    for problem in error.problems:
                        self._add(problem, "tune", "values", key)


def _middle(column: Column) -> Any:
    """Return the lower of the middle values of numbers, else the most frequent value."""
    if column.is_number:
        return np.sort(column.values)[(len(column.values) - 1) // 2].item()
    texts = Counter(json.dumps(column.value(run)) for run in range(len(column.values)))
    [(text, _)] = texts.most_common(1)
    return json.loads(text)


def _extremes(column: Column) -> list[Any]:
    if column.is_number and not column.target.is_structural:
        return [np.min(column.values).item(), np.max(column.values).item()]
    seen: dict[str, Any] = {}
    for run in range(len(column.values)):
        value = column.value(run)
        seen.setdefault(json.dumps(value), value)
        if len(seen) >= _MOST_CHECKED:
            break
    found = list(seen.values())
    return found if not column.is_number or len(found) <= 20 else [min(found), max(found)]


def _unit_of_measure(measure: Measure, plan: Plan) -> str:
    if measure.kind in ("first_crossing", "settling_time"):
        return "s"
    if measure.kind == "function":
        return "1"
    system = plan.base.system
    own = system.port(measure.signals[0]).variable.unit_name
    if measure.other is None:
        return own
    return f"{own}.{system.port(measure.other).variable.unit_name}.s"


class _Base:
    """Values of the system as it is."""

    def __init__(self, base: Experiment) -> None:
        self._system = base.system

    def value(self, signal: str) -> Any:
        fault = signal_fault(self._system.descriptions, signal, None)
        if fault is not None:
            raise ValueError(fault)
        instance, _, name = signal.partition(".")
        found = self._system.instances[instance].value_of(name)
        if found is None:
            raise ValueError(
                Problem("has no value before the run", got=signal, expected="a parameter or start value")
            )
        variable = self._system.instances[instance].description.by_name[name]
        return bool(found) if variable.kind.value.lower() == "boolean" else found

    def unit(self, signal: str) -> Unit | None:
        instance, _, name = signal.partition(".")
        described = self._system.descriptions.get(instance)
        variables = () if described is None else named_by(described, name)
        return variables[0].unit if variables else None

"""From a YAML file and a request to a system that is ready to step; nothing is stepped here."""

from __future__ import annotations

import atexit
import shutil
import tempfile
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from master import catalogue
from master.coupling.methods.method import Method
from master.coupling.schedule import Schedule, make_schedule
from master.errors import ConfigError, Problem, nearest
from master.fmi.description import Description
from master.fmi.description_reader import read_description
from master.installation import configuration
from master.isolation import sandbox
from master.isolation.options import IS_POSSIBLE, Isolation
from master.recording.selection import Selection
from master.ssp.names import SUFFIXES
from master.stepping.recorded import recorded_ports
from master.system.config import UNKNOWN_SOURCE, LoadedConfig, read_config, with_times
from master.system.graph import Descriptions, System, join
from master.system.grid import Grid
from master.system.inputs import MeasuredInputs, measured_inputs, with_first_values
from master.system.scenario import Scenario, make_scenario
from master.text.scalar import Setting
from master.text.signal_name import SignalName
from master.text.yaml_lines import parse_value

from .experiment import Experiment
from .phase_lead import is_switched_off, lead_task

ALL = "all"

Overrides = dict[str, tuple[str, Setting]]
"""Signal to the place where its value is given, and the value."""


@dataclass(frozen=True)
class Request:
    """
    What the user asks for in addition to the file.

    `isolate`: FMUs that get a process of their own, ALL for each; `sandbox`: whether these are shut in, all
    FMUs where none is named.
    """

    variant: str | None = None
    assignments: tuple[str, ...] = ()
    stop_time: float | None = None
    step_size: float | None = None
    flavour: str = "native"
    inputs: Path | None = None
    record: tuple[str, ...] = ()
    every: int | None = None
    isolate: tuple[str, ...] = ()
    sandbox: bool = False


def prepare(
    source: Path | LoadedConfig,
    request: Request | None = None,
    progress: catalogue.Progress = catalogue.silent,
    given: Mapping[str, Description] | None = None,
) -> Experiment:
    """
    Read, check and complete a system; builds FMUs that are missing or stale. No FMU is loaded.

    Args:
        source: A YAML file, an SSP archive, the name of a configuration that is shipped, or what was read.
        request: What is asked for in addition.
        progress: Told what is built.
        given: Descriptions of instances that are no FMUs; their sources are not looked at.

    Raises:
        ConfigError: With every fault of the file and the request.
    """
    request = request or Request()
    loaded = source if isinstance(source, LoadedConfig) else read_system(source, request)
    return _Preparation(loaded, request, progress, given or {}).experiment()


def read_system(source: Path, request: Request) -> LoadedConfig:
    """
    Read a YAML file, an SSP archive or a configuration that is shipped.

    Raises:
        ConfigError: If too little is right to check the rest; other faults are in its `problems`.
    """
    path = configuration(source)
    if path.suffix.lower() not in SUFFIXES:
        return read_config(path)
    from master.ssp.reader import read_ssp

    folder = Path(tempfile.mkdtemp(prefix="dockloop-"))
    atexit.register(shutil.rmtree, folder, ignore_errors=True)
    try:
        return read_ssp(path, folder, request.step_size, request.stop_time)
    except BaseException:
        shutil.rmtree(folder, ignore_errors=True)
        raise


class _Preparation:
    """The stages of a preparation; each adds its faults, and the next goes on with what is right."""

    def __init__(
        self,
        loaded: LoadedConfig,
        request: Request,
        progress: catalogue.Progress,
        given: Mapping[str, Description],
    ) -> None:
        self.loaded = loaded
        self.request = request
        self.progress = progress
        self.given = given
        self.problems: list[str] = list(loaded.problems)

    def experiment(self) -> Experiment:
        """Go through all stages."""
        loaded = self._with_times()
        descriptions = self._descriptions()
        overrides = self._overrides(descriptions)
        system, problems = join(loaded, descriptions, overrides)
        self.problems += problems
        system = self._isolated(system)
        schedule = self._schedule(system)
        longer = max(loaded, self.loaded, key=lambda one: one.config.stop_time)  # events may be cut off
        scenario = self._scenario(longer, system)
        if schedule is not None:
            where = self.loaded.where("events")
            faults = schedule.event_faults(system, scenario.channels())
            self.problems += [f"{where}: {fault}" for fault in faults]
        loaded = self._with_input_file(loaded, system)
        inputs = self._inputs(loaded, system)
        self._check_phase_lead(system)
        selection = self._selection(system)
        plots = self._plots(system)
        if self.problems or schedule is None:
            raise ConfigError(self.problems)
        return Experiment(
            config=loaded.config,
            variant=self.request.variant,
            system=with_first_values(system, inputs),
            schedule=schedule,
            scenario=scenario,
            overridden=frozenset(overrides),
            remarks=loaded.notes,
            is_designed=loaded.is_designed,
            inputs=inputs,
            selection=selection,
            plots=plots,
        )

    def _isolated(self, system: System) -> System:
        """Isolate the FMUs that the request names."""
        named = [name for given in self.request.isolate for name in given.split(",")]
        known = self.loaded.config.fmus
        unknown = [name for name in named if name != ALL and name not in known]
        self.problems += [
            Problem(
                "no such FMU", where="--isolate", got=repr(n), expected=nearest(n, self.loaded.config.fmus)
            )
            for n in unknown
        ]
        is_all = ALL in named or (self.request.sandbox and not named)
        instances = dict(system.instances)
        for name, instance in system.instances.items():
            if is_all or name in named or instance.isolation is not None:
                isolation = replace(instance.isolation or Isolation(), is_sandboxed=self.request.sandbox)
                instances[name] = replace(instance, isolation=isolation)
        is_isolated = any(i.isolation is not None for i in instances.values())
        if is_isolated and not IS_POSSIBLE:
            self.problems.append(
                Problem(
                    "no process for an FMU of its own on this system", expected="Linux on x86_64 or aarch64"
                )
            )
        if self.request.sandbox and (lack := sandbox.what_is_missing()):
            expected = "a system that has it, or a container without --sandbox"
            self.problems.append(Problem(lack, where="--sandbox", expected=expected))
        return replace(system, instances=instances)

    def _with_times(self) -> LoadedConfig:
        if self.request.stop_time is None and self.request.step_size is None:
            return self.loaded
        try:
            config = with_times(self.loaded.config, self.request.step_size, self.request.stop_time)
        except ConfigError as error:
            self.problems += error.problems
            return self.loaded
        return replace(self.loaded, config=config)

    def _descriptions(self) -> Descriptions:
        """Description of each FMU of the file; None for those that are wrong or cannot be read."""
        targets = {}
        for name, entry in self.loaded.config.fmus.items():
            if entry.source == UNKNOWN_SOURCE or name in self.given:
                continue
            try:
                targets[name] = catalogue.locate(entry.source, self.loaded.folder, self.request.flavour)
            except ConfigError as error:
                self._add_at(error, "fmus", name, "source")
        if self.problems:  # nothing is built for a system that is refused
            targets = {name: t for name, t in targets.items() if catalogue.is_ready(t)}
        found: dict[str, Description | None] = dict.fromkeys(self.loaded.document.names_in("fmus"))
        found |= dict.fromkeys(self.loaded.config.fmus) | dict(self.given)
        for name, file in catalogue.files(targets, self.progress).items():
            try:
                found[name] = read_description(file)
            except ConfigError as error:
                self._add_at(error, "fmus", name, "source")
        return found

    def _add_at(self, error: ConfigError, *place: str) -> None:
        where = self.loaded.where(*place)
        self.problems += [problem.at(where) for problem in error.problems]

    def _overrides(self, descriptions: Descriptions) -> Overrides:
        """Values of the variant, and over them those of `--set`."""
        found: Overrides = {}
        variants = self.loaded.config.variants
        chosen = self.request.variant
        known = self.loaded.document.names_in("variants") or list(variants)
        if chosen is not None and chosen not in known:
            expected = nearest(chosen, known)
            self.problems.append(
                Problem("no such variant", where="--variant", got=repr(chosen), expected=expected)
            )
        for fmu, values in variants.get(chosen or "", {}).items():
            for key, value in values.items():
                where = self.loaded.where("variants", chosen or "", fmu, key)
                found[f"{fmu}.{key}"] = (where, value)
        return found | self._assignments(descriptions)

    def _assignments(self, descriptions: Descriptions) -> Overrides:
        found: Overrides = {}
        for assignment in self.request.assignments:
            try:
                parts = _signal_and_value(assignment, descriptions)
            except ConfigError as error:
                self.problems += [problem.at("--set") for problem in error.problems]
                continue
            if parts is None:
                self.problems.append(
                    Problem(
                        "not an assignment",
                        where="--set",
                        got=repr(assignment),
                        expected="fmu.parameter=value",
                    )
                )
                continue
            signal, value = parts
            if signal in found:
                where = f"--set {signal}"
                self.problems.append(Problem("is given twice", where=where, expected="one value"))
            found[signal] = (f"--set {signal}", value)
        return found

    def _schedule(self, system: System) -> Schedule | None:
        order = self.loaded.config.coupling.order
        if system.unread and order is not None:
            order = _without(order, system.unread)
        try:
            return make_schedule(system, order, self.loaded.where("coupling", "order"))
        except ConfigError as error:
            self.problems += error.problems
        return None

    def _scenario(self, loaded: LoadedConfig, system: System) -> Scenario:
        try:
            return make_scenario(loaded, system)
        except ConfigError as error:
            self.problems += error.problems
        return Scenario()

    def _with_input_file(self, loaded: LoadedConfig, system: System) -> LoadedConfig:
        if self.request.inputs is None or system.unread:
            return loaded
        from master.system.input_option import with_input_file  # reads a table with numpy

        try:
            return with_input_file(loaded, self.request.inputs, system)
        except ConfigError as error:
            self.problems += error.problems
        return loaded

    def _inputs(self, loaded: LoadedConfig, system: System) -> MeasuredInputs:
        config = loaded.config
        grid = Grid(config.start_time, config.step_size, config.n_ticks)
        try:
            return measured_inputs(loaded, system, grid)
        except ConfigError as error:
            self.problems += error.problems
        return MeasuredInputs()

    def _selection(self, system: System) -> Selection:
        """What goes to the result files: as the file says, `--record` and `--every` over it."""
        record = self.loaded.config.record
        if self.request.record:
            named = [("--record", signal) for signal in self.request.record]
        else:
            where = self.loaded.where("record", "signals")
            named = [(where, str(signal)) for signal in record.signals]
        chosen: list[str] = []
        for where, signal in named:
            chosen += self._recorded(system, where, signal)
        every = record.every if self.request.every is None else self.request.every
        return Selection(tuple(dict.fromkeys(chosen)), every)

    def _plots(self, system: System) -> tuple[tuple[str, ...], ...]:
        """Signals of each plot that the file asks for."""
        groups = []
        for i, plot in enumerate(self.loaded.config.plots or ()):
            where = self.loaded.where("plots", i)
            groups.append(tuple(name for signal in plot for name in self._recorded(system, where, signal)))
        return tuple(groups)

    def _recorded(self, system: System, where: str, signal: str) -> list[str]:
        """Names of the columns that a signal is: its own, or those of the elements of an array."""
        known = [port.name for port in recorded_ports(system)]
        instance, _, variable = signal.partition(".")
        described = system.descriptions.get(instance)
        elements = () if described is None else described.arrays.get(variable, ())
        found = [name for name in (signal, *(f"{instance}.{v.name}" for v in elements)) if name in known]
        if not found and instance not in system.unread:
            expected = nearest(signal, known)
            self.problems.append(Problem("no such output", where=where, got=repr(signal), expected=expected))
        return found

    def _check_phase_lead(self, system: System) -> None:
        """Refuse a phase lead that cannot be designed, unless it is switched off."""
        config = self.loaded.config
        if config.dpdc is None or system.unread or is_switched_off(system, config.dpdc):
            return
        try:
            lead_task(system, config.compare, config.dpdc, self.loaded.where("dpdc"))
        except ConfigError as error:
            self.problems += error.problems


def _signal_and_value(assignment: str, descriptions: Descriptions) -> tuple[str, Setting] | None:
    """Cut `fmu.variable=value` after the longest name that there is, else at the first `=`."""
    places = [i for i, character in enumerate(assignment) if character == "="]
    known = [i for i in places if _is_known(assignment[:i], descriptions)]
    if not places:
        return None
    cut = known[-1] if known else places[0]
    try:
        name = SignalName(assignment[:cut])
        value = parse_value(assignment[cut + 1 :])
    except ValueError:
        return None
    except ConfigError as error:
        if all(problem.what.startswith("not ") for problem in error.problems):  # not YAML, not a value
            return None
        raise ConfigError(problem.at(name) for problem in error.problems) from None
    return None if value is None else (name, value)


def _is_known(signal: str, descriptions: Descriptions) -> bool:
    instance, _, variable = signal.partition(".")  # what is cut anywhere may be no name
    description = descriptions.get(instance)
    return description is not None and (variable in description.by_name or variable in description.arrays)


def _without(
    order: Sequence[str | list[str] | Method], unread: Sequence[str]
) -> list[str | list[str] | Method]:
    """Leave the FMUs that could not be read out of an order, and groups that have no others."""
    kept: list[str | list[str] | Method] = []
    for entry in order:
        names = (entry,) if isinstance(entry, str) else entry.members if isinstance(entry, Method) else entry
        members = [name for name in names if name not in unread]
        if not members:
            continue
        if isinstance(entry, Method):
            kept.append(entry.model_copy(update={"members": tuple(members)}))
        else:
            kept.append(entry if isinstance(entry, str) else members)
    return kept

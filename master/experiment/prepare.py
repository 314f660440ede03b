"""Read a system file with a request, check it, and build what is missing."""

from __future__ import annotations

import atexit
import shutil
import tempfile
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from yaml import YAMLError

from master import catalogue
from master.coupling.schedule import make_schedule
from master.errors import ConfigError, expected
from master.experiment.experiment import Experiment
from master.fmi.description import Description, read_description
from master.ssp.reader import read_ssp
from master.system.config import LoadedConfig, Value, load_config, with_stop_time
from master.system.graph import build_system
from master.system.scenario import make_scenario
from master.text.yaml_lines import parse_value


@dataclass(frozen=True)
class Request:
    """What the user asks for beside the file."""

    variant: str | None = None
    assignments: tuple[str, ...] = ()
    stop_time: float | None = None
    flavour: str = "native"


def prepare(
    path: Path, request: Request | None = None, progress: catalogue.Progress = catalogue.silent
) -> Experiment:
    """
    Read, check and complete a system; builds FMUs that are missing or stale.

    Raises:
        ConfigError: With every fault found at the first stage that finds any.
    """
    request = request or Request()
    loaded = from_file = _load(path)
    if request.stop_time is not None:
        config = with_stop_time(loaded.config, request.stop_time)
        loaded = LoadedConfig(config=config, document=loaded.document)
    overrides = _overrides(loaded, request)
    files = _fmu_files(loaded, request.flavour, progress)
    system = build_system(loaded, _descriptions(loaded, files), overrides)
    order = loaded.config.coupling.order
    schedule = make_schedule(system, order, loaded.where("coupling", "order"))
    longer = max(loaded, from_file, key=lambda one: one.config.stop_time)  # --stop-time may cut events off
    scenario = make_scenario(longer, system)
    experiment = Experiment(loaded.config, request.variant, system, schedule, scenario)
    return experiment if loaded.config.dpdc is None else _with_phase_lead(experiment, set(overrides))


def _with_phase_lead(experiment: Experiment, overridden: set[str]) -> Experiment:
    """Design the phase lead, unless it is switched off or set by hand."""
    from master.docking.phase_lead import designed

    return designed(experiment, overridden)


def _load(path: Path) -> LoadedConfig:
    if path.suffix != ".ssp":
        return load_config(path)
    folder = Path(tempfile.mkdtemp(prefix="dockloop-"))
    atexit.register(shutil.rmtree, folder, ignore_errors=True)
    return read_ssp(path, folder)


def _overrides(loaded: LoadedConfig, request: Request) -> dict[str, tuple[str, Value]]:
    found: dict[str, tuple[str, Value]] = {}
    if request.variant is not None:
        for fmu, values in _variant(loaded, request.variant).items():
            for key, value in values.items():
                where = loaded.where("variants", request.variant, fmu, key)
                found[f"{fmu}.{key}"] = (where, value)
    problems = []
    for assignment in request.assignments:
        signal, equals, text = assignment.partition("=")
        given = _value(text) if equals else None
        if "." in signal and isinstance(given, bool | int | float | str):
            found[signal] = (f"--set {signal}", given)
        else:
            problems.append(f"--set: not an assignment, got {assignment!r}, expected fmu.parameter=value")
    if problems:
        raise ConfigError(problems)
    return found


def _value(text: str) -> Any:
    try:
        return parse_value(text)
    except YAMLError:
        return None


def _variant(loaded: LoadedConfig, name: str) -> Mapping[str, Mapping[str, Value]]:
    variants = loaded.config.variants
    if name not in variants:
        raise ConfigError([f"--variant: no such variant, got {name!r}, {expected(name, variants)}"])
    return variants[name]


def _fmu_files(loaded: LoadedConfig, flavour: str, progress: catalogue.Progress) -> dict[str, Path]:
    problems: list[str] = []
    targets = {}
    for name, entry in loaded.config.fmus.items():
        try:
            targets[name] = catalogue.locate(entry.source, loaded.folder, flavour)
        except ConfigError as error:
            where = loaded.where("fmus", name, "source")
            problems += [f"{where}: {problem}" for problem in error.problems]
    if problems:
        raise ConfigError(problems)
    return catalogue.files(targets, progress)


def _descriptions(loaded: LoadedConfig, files: Mapping[str, Path]) -> dict[str, Description]:
    problems: list[str] = []
    found = {}
    for name, file in files.items():
        try:
            found[name] = read_description(file)
        except ConfigError as error:
            where = loaded.where("fmus", name, "source")
            problems += [f"{where}: {problem}" for problem in error.problems]
    if problems:
        raise ConfigError(problems)
    return found

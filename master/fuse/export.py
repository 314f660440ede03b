"""One FMU from a prepared system: read its FMUs' sources, generate, compile, describe, pack."""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path

from fmu_sources.export import native
from fmu_sources.export.archive import pack
from fmu_sources.export.facts import guid
from fmu_sources.export.native.compile import compile_host, compile_release
from fmu_sources.export.whole_file import write_whole
from master.errors import ConfigError, Problem
from master.experiment.experiment import Experiment
from master.fmi.description import Description

from .description import describe_fmi2, describe_fmi3
from .events_c import refused_events
from .foreign import ForeignModel, foreign_model, refusals
from .inner import InnerModel, NoSourcesError, digest, inner_model, source_files
from .layout import Fused, Inner
from .page import documentation_files
from .refusal import refuse
from .sources import sources

VERSIONS = ("2.0", "3.0")


@dataclass(frozen=True)
class Written:
    """What was written: the file, and how many FMUs and variables it holds."""

    path: Path
    n_fmus: int
    n_variables: int


def fused_system(experiment: Experiment, *, carries: bool = False) -> Fused:
    """
    Read the sources of a system's FMUs.

    Args:
        experiment: The system.
        carries: Whether it becomes an FMU, which has connectors and carries FMUs without known sources along.

    Raises:
        ConfigError: With every reason why the system cannot be one FMU.
    """
    refuse(experiment, is_exported=carries)
    system = experiment.system
    problems: list[Problem] = []
    models: dict[str, InnerModel] = {}
    inners: dict[str, Inner] = {}
    for number, (name, instance) in enumerate(system.instances.items()):
        try:
            model = _model(instance.description, models)
        except NoSourcesError as error:
            if not carries:
                problems.append(
                    Problem(
                        "cannot be compiled with the others",
                        where=f"fmus.{name}",
                        got=str(error),
                        expected="a native FMU of this project with its sources",
                    )
                )
                continue
            problems += refusals(instance, system)
            if problems:
                continue
            model = foreign_model(instance, system, f"f{number}_")
            models[name] = model
        inners[name] = Inner(number, model, instance)
    if problems:
        raise ConfigError(problems)
    fused = Fused(
        name=experiment.title,
        identifier=_identifier(experiment.title),
        description=experiment.config.description,
        grid=experiment.grid,
        scenario=experiment.scenario,
        system=experiment.system,
        schedule=experiment.schedule,
        models=tuple(models.values()),
        inners=inners,
    )
    problems += refused_events(experiment.scenario, fused)
    if carries:
        problems += fused.unit_problems()
    if problems:
        raise ConfigError(problems)
    return fused


def _model(description: Description, known: dict[str, InnerModel]) -> InnerModel:
    """The sources of an FMU; instances of the same model share them."""
    files = source_files(description)
    key = digest(files)
    if key not in known:
        known[key] = inner_model(files, description.model_identifier, f"m{len(known)}_")
    return known[key]


def _identifier(title: str) -> str:
    """Make a name of C of a title."""
    name = re.sub(r"\W+", "_", title, flags=re.ASCII).strip("_") or "system"
    return name if not name[0].isdigit() else f"system_{name}"


def fused_fmu(fused: Fused, fmi_version: str, *, all_platforms: bool = False) -> bytes:
    """
    Generate, compile and pack the FMU of a system.

    Args:
        fused: The system with the sources of its FMUs.
        fmi_version: One of `VERSIONS`.
        all_platforms: Compile for the platforms of a release, with zig, and not for this machine alone.

    Raises:
        ConfigError: If the program of a tick is too long.
        NativeBuildError: If this machine lacks a tool, or the compiler fails.
    """
    draft = sources(fused, "")
    describe = describe_fmi2 if fmi_version == "2.0" else describe_fmi3
    token = guid(describe(fused, "", ()), *draft.values())
    files = sources(fused, token)
    if all_platforms:
        binaries = compile_release(files, fused.identifier)
    else:
        library = compile_host(files, fused.identifier)
        binaries = {
            f"binaries/{folder}/{fused.identifier}{ending}": library
            for folder, ending in native.host_folders()
        }
    contents = {f"sources/{name}": content for name, content in files.items()}
    contents |= documentation_files(fused)
    for model in fused.models:
        if isinstance(model, ForeignModel):
            contents |= model.archive()
    contents["modelDescription.xml"] = describe(fused, token, tuple(native.c_files(files)))
    if fmi_version == "3.0":
        contents["sources/buildDescription.xml"] = native.build_description(files, fused.identifier)
    return pack(contents | native.of_version(binaries, fmi_version))


def write_fmu(
    experiment: Experiment, path: Path, fmi_version: str = "2.0", *, all_platforms: bool = False
) -> Written:
    """
    Write the FMU of a system.

    Raises:
        ConfigError: With every reason why the system cannot be one FMU, or why it cannot be compiled here.
    """
    fused = fused_system(experiment, carries=True)
    if all_platforms and fused.has_foreign:
        raise ConfigError(
            [
                Problem(
                    "FMUs that are not of this project are carried along for this machine alone",
                    where="--all-platforms",
                    got=", ".join(i.name for i in fused.inners.values() if i.model.is_foreign),
                    expected="FMUs with sources of this project",
                )
            ]
        )
    try:
        content = fused_fmu(fused, fmi_version, all_platforms=all_platforms)
    except native.NativeBuildError as error:
        raise ConfigError([str(error)]) from None
    try:
        write_whole(path, content)
    except OSError as error:
        raise ConfigError([f"{path}: cannot be written, got {error}"]) from None
    return Written(path, len(fused.inners), sum(v.described is not None for v in fused.variables))

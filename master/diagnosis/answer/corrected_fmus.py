"""The model with the effect: FMUs of both flavours, and a system that is ready for `dockloop run`."""

from __future__ import annotations

import os
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from fmu_sources.export.build import build_with_starts
from master import catalogue
from master.diagnosis.case.cut import CutSystem
from master.diagnosis.judge.diagnose import Diagnosis
from master.diagnosis.judge.part_result import PartResult
from master.diagnosis.replay.own_values import AT
from master.diagnosis.replay.placed_effect import source_with
from master.experiment.prepare import prepare
from master.recording.whole_file import write_whole
from master.ssp.parameter_set import parameter_set
from master.text.signal_name import SignalName
from master.text.yaml_lines import write_yaml

from .before_after import SealedPart
from .driven import driven_inputs, write_inputs

FLAVOURS = ("native", "python")
HEAD = "# {name} with what the recording asks for; written by `dockloop diagnose`.\n"


@dataclass(frozen=True)
class Corrected:
    """Files of the corrected models: FMU to native file, all files, and the system."""

    native: Mapping[str, Path]
    files: tuple[Path, ...]
    system: Path


def correct(diagnosis: Diagnosis, folder: Path) -> Corrected:
    """Write the corrected system, and its new FMUs in both flavours, into a folder."""
    system = diagnosis.system
    sources = _sources(diagnosis)
    native: dict[str, Path] = {}
    files: list[Path] = []
    values = corrected_values(diagnosis)
    for fmu, source in sources.items():
        if source == system.sources[fmu]:
            continue
        own = values.get(fmu, {})
        for flavour in FLAVOURS[:1] if catalogue.is_own(system.config.fmus[fmu].source) else FLAVOURS:
            path = folder / flavour / f"{_file_name(fmu, source, sources)}.fmu"
            files.append(build_with_starts(source, own, flavour, path))
            if flavour == "native":
                native[fmu] = path
        if own:
            path = folder / f"{fmu}.ssv"
            write_whole(path, parameter_set(own))
            files.append(path)
    path = folder / f"{diagnosis.loaded.case.name}_corrected.yaml"
    document = _document(diagnosis, native, folder)
    inputs = driven_inputs(system, (c["to"] for c in document.get("connections", [])))
    if inputs:
        recording = next(iter(diagnosis.recordings.values()))
        table = folder / f"{diagnosis.loaded.case.name}_inputs.parquet"
        document |= write_inputs(table, inputs, recording)
        files.append(table)
    text = HEAD.format(name=diagnosis.loaded.case.name)
    text += write_yaml(document)
    write_whole(path, text)
    return Corrected(native, (*files, path), path)


def confirmed(
    diagnosis: Diagnosis, corrected: Corrected, sealed: Mapping[str, SealedPart], folder: Path
) -> Corrected:
    """Take back what the sealed rows do not confirm, and prepare what is left as a system that runs."""
    if not any(_is_refuted(p, sealed[p.name]) for p in diagnosis.parts):
        prepare(corrected.system)
        return corrected
    for file in corrected.files:
        file.unlink()
    for flavour in FLAVOURS:
        with suppress(OSError):
            (folder / flavour).rmdir()
    return Corrected({}, (), corrected.system)


def _is_refuted(part: PartResult, sealed: SealedPart) -> bool:
    """Whether the sealed rows do not confirm a part's effects, or its other numbers without any."""
    if part.has_effect:
        return not sealed.is_confirmed
    return part.parameter_gain and sealed.is_refit_worse


def corrected_values(diagnosis: Diagnosis) -> dict[str, dict[str, float]]:
    """
    Parameters by FMU that were fitted, of base and effects.

    Of those that every recording has for itself, the values of the one that drives the corrected system.
    """
    values: dict[str, dict[str, float]] = {}
    for part in diagnosis.parts:
        if not part.has_effect and not part.parameter_gain:
            continue
        for key, value in part.values.items():
            if AT in key and not key.endswith(f"{AT}{_driving(diagnosis)}"):
                continue
            name = SignalName(key.partition(AT)[0])
            values.setdefault(name.instance, {})[name.variable] = float(value)
    return values


def _driving(diagnosis: Diagnosis) -> str:
    first = next(iter(diagnosis.recordings.values()))
    return first.entry or first.name


def _sources(diagnosis: Diagnosis) -> dict[str, str]:
    system = diagnosis.system
    effects = [e for part in diagnosis.parts for e in part.chosen.effects]
    return {
        fmu: source_with(source, [e for e in effects if e.fmu == fmu])
        for fmu, source in system.sources.items()
    }


def _file_name(fmu: str, source: str, sources: Mapping[str, str]) -> str:
    """Name of an FMU's file: its model's, with the instance's where two are made of one model."""
    return source if list(sources.values()).count(source) == 1 else f"{fmu}_{source}"


def _document(diagnosis: Diagnosis, native: Mapping[str, Path], folder: Path) -> dict[str, Any]:
    """The description of the system with other sources and parameters."""
    system = diagnosis.system
    case = diagnosis.loaded.case
    data = system.config.model_dump(by_alias=True, exclude_defaults=True)
    overrides: Mapping[str, Any] = {} if case.variant is None else system.config.variants[case.variant]
    values = corrected_values(diagnosis)
    for fmu, entry in data["fmus"].items():
        entry["source"] = _source(system, fmu, native, folder)
        given = dict(entry.get("parameters", {}))
        given |= dict(overrides.get(fmu, {})) | values.get(fmu, {})
        if given:
            entry["parameters"] = given
    data["name"] = f"{case.name}_corrected"
    return dict(data)


def _source(system: CutSystem, fmu: str, native: Mapping[str, Path], folder: Path) -> str:
    if fmu in native:
        return f"./{native[fmu].relative_to(folder).as_posix()}"
    source = system.config.fmus[fmu].source
    if not catalogue.is_path(source):
        return source
    return Path(os.path.relpath(system.folder / source, folder)).as_posix()

"""What SSP has no word for, as JSON in an annotation of the outermost system: written and read here."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from master.errors import ConfigError, expected
from master.system.config import Config
from master.text.scalar import Plain

from .packed_recordings import PackedRecordings
from .prepared import PreparedSystem
from .structure import Annotation

# parts of a configuration that are kept as they are
PARTS = (
    "coupling",
    "compare",
    "dpdc",
    "events",
    "inputs",
    "limits",
    "plots",
    "record",
    "stop_when",
    "variants",
)
# parts that the structure itself holds
_SAID_BY_SSP = (
    "name",
    "description",
    "step_size",
    "start_time",
    "stop_time",
    "fmus",
    "connections",
    "connectors",
)
_WIRE = ("delay", "extrapolation", "tolerance")
_KEYS = ("step_size", "every", "connections", "start", "given", "files", *PARTS)


@dataclass(frozen=True)
class Coupling:
    """
    The annotation's content.

    `connections` has for each one (source, target) what the structure does not say of it; `start` has values
    that a parameter set cannot hold, by FMU and variable, `given` those of the system's own inputs; `files`
    are the recordings in the archive by the names that `inputs` has for them; `parts` are sections of the
    YAML form.
    """

    step_size: float | None = None
    every: Mapping[str, Any] = field(default_factory=dict)
    connections: Mapping[tuple[str, str], Mapping[str, Any]] = field(default_factory=dict)
    start: Mapping[str, Mapping[str, Any]] = field(default_factory=dict)
    given: Mapping[str, Any] = field(default_factory=dict)
    files: Mapping[str, Any] = field(default_factory=dict)
    parts: Mapping[str, Any] = field(default_factory=dict)


def write_coupling(
    experiment: PreparedSystem, start: Mapping[str, Mapping[str, Any]], recordings: PackedRecordings
) -> str:
    """
    Write the annotation.

    Args:
        experiment: The system.
        start: Values that a parameter set cannot hold, by FMU and variable.
        recordings: What the archive holds of recordings.

    Raises:
        ConfigError: If the configuration has a part that an SSP cannot keep.
    """
    config, system = experiment.config, experiment.system
    unknown = [key for key in Config.model_fields if key in config.model_fields_set - {*PARTS, *_SAID_BY_SSP}]
    if unknown:
        raise ConfigError(
            [f"{key}: cannot be written as SSP, expected a system without it" for key in unknown]
        )
    is_one_variant = experiment.variant is not None or config.dpdc is not None
    parts = set(PARTS) - ({"variants"} if is_one_variant else set())
    kept = config.model_dump(by_alias=True, exclude_unset=True, include=parts)
    data = {
        "step_size": config.step_size,
        "every": {name: i.every for name, i in system.instances.items() if i.every > 1},
        "connections": [
            {
                "from": wire.source.name,
                "to": wire.target.name,
                **{key: value for key in _WIRE if (value := getattr(wire, key))},
            }
            for wire in (*system.wires, *system.inlets, *system.outlets)
        ],
        **kept,
    }
    data.pop("inputs", None)
    left = [one for i, one in enumerate(config.inputs) if i not in recordings.in_components]
    if left:
        data["inputs"] = [one.model_dump(by_alias=True, exclude_unset=True) for one in left]
        data["files"] = {one.file: recordings.members[one.file] for one in left}
    if system.given:
        data["given"] = dict(system.given)
    if start:
        data["start"] = start
    return json.dumps(data, sort_keys=True)


def read_coupling(annotation: Annotation) -> Coupling:
    """
    Read the annotation.

    Raises:
        ConfigError: With every part that is not understood.
    """
    where = f"{annotation.where}: Coupling"
    try:
        data = json.loads(annotation.text)
    except (ValueError, RecursionError):
        raise ConfigError([f"{where}: not JSON, got {annotation.text[:60]!r}"]) from None
    if not isinstance(data, dict):
        raise ConfigError([f"{where}: not understood, got {type(data).__name__}, expected an object"])
    problems = [f"{where}: unknown key, {expected(key, _KEYS)}" for key in data if key not in _KEYS]
    step_size = data.get("step_size")
    if step_size is not None and (isinstance(step_size, bool) or not isinstance(step_size, int | float)):
        problems.append(f"{where}: step_size is not a number, got {step_size!r}")
    for key in ("every", "start", "given", "files"):
        if not isinstance(data.get(key, {}), dict):
            problems.append(f"{where}: {key} is not understood, got {data[key]!r}, expected an object")
    for name, values in data.get("start", {}).items() if isinstance(data.get("start"), dict) else ():
        if not isinstance(values, dict):
            problems.append(f"{where}: start of {name} is not understood, got {values!r}, expected an object")
    connections = _connections(data.get("connections", []), where, problems)
    if problems:
        raise ConfigError(problems)
    return Coupling(
        step_size=step_size,
        every=data.get("every", {}),
        connections=connections,
        start=data.get("start", {}),
        given=data.get("given", {}),
        files=data.get("files", {}),
        parts={key: _as_written(data[key]) for key in PARTS if key in data},
    )


def _as_written(value: Any) -> Any:
    """Texts as in a YAML file: the type of the variable that they are for decides what they are."""
    if isinstance(value, dict):
        return {key: _as_written(inner) for key, inner in value.items()}
    if isinstance(value, list):
        return [_as_written(inner) for inner in value]
    return Plain(value) if isinstance(value, str) and not Plain(value).is_null else value


def _connections(given: Any, where: str, problems: list[str]) -> dict[tuple[str, str], Mapping[str, Any]]:
    found: dict[tuple[str, str], Mapping[str, Any]] = {}
    if not isinstance(given, list):
        problems.append(f"{where}: connections is not understood, got {given!r}, expected a list")
        return found
    for i, entry in enumerate(given):
        if not (
            isinstance(entry, dict)
            and isinstance(entry.get("from"), str)
            and isinstance(entry.get("to"), str)
        ):
            problems.append(
                f"{where}: connections[{i}] is not understood, got {entry!r}, expected from and to"
            )
            continue
        more = {key: value for key, value in entry.items() if key not in ("from", "to")}
        problems += [
            f"{where}: connections[{i}]: unknown key, {expected(key, _WIRE)}"
            for key in more
            if key not in _WIRE
        ]
        found[entry["from"], entry["to"]] = more
    return found

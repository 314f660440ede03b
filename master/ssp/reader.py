"""An SSP archive, or an unpacked structure, as a configuration; what is not ours is stepped side by side."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from master.errors import ConfigError
from master.fmi.units import Conversion
from master.system.config import Config, LoadedConfig
from master.text.validation import validated
from master.text.yaml_lines import Document, Place

from .annotation import PARTS, Coupling, read_coupling
from .names import COUPLING
from .package import Archive, Folder, Package, locate
from .parse import default_structure, parse_structure
from .resolve import Resolved, ResolvedConnector, ResolvedWire, resolve
from .structure import Structure

_DEFAULT_STEP = 1e-3  # s
_DEFAULT_DURATION = 1.0  # s


@dataclass(frozen=True)
class SspDocument(Document):
    """Data whose places are elements of XML files."""

    places: Mapping[Place, str] = field(default_factory=dict)

    def where(self, place: Place) -> str:
        """Name the element that gave a value; the nearest that is known."""
        known = place
        while known and known not in self.places:
            known = known[:-1]
        return self.places.get(known, str(self.path))


def read_ssp(
    path: Path, folder: Path, step_size: float | None = None, stop_time: float | None = None
) -> LoadedConfig:
    """
    Read the system of an archive or of a structure file.

    Args:
        path: A file `*.ssp` or `*.ssd`.
        folder: Where FMUs are unpacked.
        step_size: In place of the file's [s].
        stop_time: What will take the place of the file's stop time [s], which then need not fit.

    Raises:
        ConfigError: With every fault that the first stage to find any has found.
    """
    read = _read(path, folder)
    structure = read.structure
    coupling = read.coupling
    resolved = resolve(structure, () if coupling is None else coupling.connections)
    data = _data(structure, resolved, coupling, step_size)
    document = SspDocument(path, data, places=_places(structure, resolved))
    notes = (*_notes(structure, data, coupling is None, step_size is None), *read.others)
    if coupling is None:
        notes = (*notes, *_led_in(resolved), *_rules(resolved))
    notes = (*notes, *structure.notes, *resolved.notes)
    try:
        config = validated(Config, document, "system")
    except ConfigError:
        if stop_time is None:
            raise
        data["stop_time"] = stop_time
        config = validated(Config, document, "system")
    units = {name: connector.type.unit for name, connector in resolved.connectors.items()}
    return LoadedConfig(
        config,
        document,
        notes=notes,
        is_designed=coupling is not None,
        units={name: unit for name, unit in units.items() if unit is not None},
        files={recording.member: recording.file for recording in resolved.recordings.values()}
        | dict(read.files),
    )


@dataclass(frozen=True)
class _Read:
    """A structure with what this project adds to it, the other structures next to it, and its recordings."""

    structure: Structure
    others: tuple[str, ...]
    coupling: Coupling | None
    files: Mapping[str, Path]


def _read(path: Path, folder: Path) -> _Read:
    if path.suffix.lower() == ".ssd":
        package: Package = Folder(path.parent, str(path.parent))
        if not package.has(path.name):
            raise ConfigError([f"{path}: no such file, expected a structure (.ssd)"])
        return _read_from(package, path.name, folder, ())
    archive = Archive(path, str(path))
    try:
        member = default_structure(archive)
        others = [n for n in archive.names if "/" not in n and n.lower().endswith(".ssd") and n != member]
        return _read_from(archive, member, folder, others)
    finally:
        archive.close()


def _read_from(package: Package, member: str, folder: Path, others: Sequence[str]) -> _Read:
    structure = parse_structure(package, member, folder)
    coupling = None if structure.coupling is None else read_coupling(structure.coupling)
    notes = [f"{member} is read, not {', '.join(others)}"] if others else []
    files: dict[str, Path] = {}
    if structure.coupling is not None and coupling is not None:
        base = member.rpartition("/")[0]
        where = f"{structure.coupling.where}: Coupling: inputs"
        files = _unpacked(package, base + "/" if base else "", coupling, where, folder)
    return _Read(structure, tuple(notes), coupling, files)


def _unpacked(package: Package, base: str, coupling: Coupling, where: str, folder: Path) -> dict[str, Path]:
    """Unpack the recordings that an annotation names."""
    problems: list[str] = []
    found: dict[str, Path] = {}
    for entry in _entries(coupling):
        file = entry.get("file") if isinstance(entry, dict) else None
        if not isinstance(file, str):
            continue  # the validation of the whole says so
        try:
            location = locate(package, base, str(coupling.files.get(file, file)))
            found[file] = package.unpacked(location.member, folder)
        except (ValueError, ConfigError) as error:
            reasons = error.problems if isinstance(error, ConfigError) else [f"file: {error}"]
            problems += [f"{where}: {reason}" for reason in reasons]
    if problems:
        raise ConfigError(problems)
    return found


def _entries(coupling: Coupling) -> list[Any]:
    """Entries of `inputs` of an annotation; one may be written alone."""
    inputs = coupling.parts.get("inputs", [])
    return inputs if isinstance(inputs, list) else [inputs]


def _data(
    structure: Structure, resolved: Resolved, coupling: Coupling | None, step_size: float | None
) -> dict[str, Any]:
    """Data of the YAML form."""
    given = coupling or Coupling(parts={"coupling": {"order": [list(resolved.fmus)]}})
    problems = _annotation_faults(structure, resolved, given)
    if problems:
        raise ConfigError(problems)
    asked = step_size if step_size is not None and 0.0 < step_size < math.inf else None
    start_time = 0.0 if structure.start_time is None else structure.start_time
    stop_time = structure.stop_time
    return {
        "name": _name(structure.name or structure.system.name),
        "description": structure.description,
        "step_size": asked or given.step_size or _DEFAULT_STEP,
        "start_time": start_time,
        "stop_time": start_time + _DEFAULT_DURATION if stop_time is None else stop_time,
        "fmus": {
            name: {
                "source": str(fmu.file),
                "start": {**fmu.start, **given.start.get(name, {})},
                "every": given.every.get(name, 1),
            }
            for name, fmu in resolved.fmus.items()
        },
        "connections": [_connection(wire, given) for wire in resolved.wires],
        "connectors": {
            name: {**_connector(connector), **({"start": given.given[name]} if name in given.given else {})}
            for name, connector in resolved.connectors.items()
        },
        **given.parts,
        "inputs": [*_recorded(resolved), *_entries(given)],
    }


def _name(text: str) -> str:
    """Name that a folder of results can have."""
    name = "".join("-" if c in "/\\" or not c.isprintable() else c for c in text)
    return name if name.strip(". ") else "system"


def _annotation_faults(structure: Structure, resolved: Resolved, given: Coupling) -> list[str]:
    """What the annotation names and the structure lacks: another tool has changed it."""
    if structure.coupling is None:
        return []
    where = f"{structure.coupling.where}: Coupling"
    wires = {(wire.source, wire.target) for wire in resolved.wires}
    lacking = [f"no such connection, got {s} -> {t}" for s, t in given.connections if (s, t) not in wires]
    named = {*given.every, *given.start}
    lacking += [f"no such FMU, got {name!r}" for name in sorted(named - set(resolved.fmus))]
    unknown = sorted(set(given.given) - set(resolved.connectors))
    lacking += [f"no such connector of the system, got {name!r}" for name in unknown]
    return [f"{where}: {fault}, expected one of the system" for fault in lacking]


def _connection(wire: ResolvedWire, given: Coupling) -> dict[str, Any]:
    found: dict[str, Any] = {"from": wire.source, "to": wire.target}
    if wire.conversion is not None:
        found |= _conversion(wire.conversion)
    return {**found, **given.connections.get((wire.source, wire.target), {})}


def _led_in(resolved: Resolved) -> Iterator[str]:
    """What each input of the outermost system leads to."""
    led: dict[str, list[str]] = {}
    for wire in resolved.wires:
        if wire.source in resolved.connectors and wire.source.partition(".")[0] not in resolved.recordings:
            led.setdefault(wire.source, []).append(wire.target)
    if led:
        said = [f"{name} -> {', '.join(targets)}" for name, targets in led.items()]
        yield f"inputs of the system: {'; '.join(said)}"


def _rules(resolved: Resolved) -> Iterator[str]:
    if next(_recorded(resolved), None) is not None:
        yield (
            "recordings: between two samples a Real lies on the line, others keep the last one; "
            "the step from t to t + h uses the value at t, as that of any component"
        )


def _recorded(resolved: Resolved) -> Iterator[dict[str, Any]]:
    """
    Inputs that recordings drive: real numbers lie on a line between two samples, others are held.

    A recording is one of the components that step side by side: the others get its outputs of before.
    """
    for owner, recording in resolved.recordings.items():
        columns: dict[str, dict[str, Any]] = {"linear": {}, "hold": {}}
        for name, connector in resolved.connectors.items():
            if name.partition(".")[0] == owner:
                rule = "linear" if connector.type.kind == "Real" else "hold"
                columns[rule][name] = {"column": name.partition(".")[2]}
        for rule, own in columns.items():
            if own:
                yield {
                    "file": recording.member,
                    "time": {"column": recording.time},
                    "map": own,
                    "interpolation": rule,
                    "at": "start",
                }


def _connector(connector: ResolvedConnector) -> dict[str, Any]:
    kind = _TYPES[connector.type.kind]
    unit = connector.type.unit
    found: dict[str, Any] = {"kind": connector.kind, "type": kind, "items": dict(connector.type.items)}
    if unit is not None:
        found["unit"] = unit.name
    if connector.shape:
        found["shape"] = list(connector.shape)
    if connector.start is not None:
        found["start"] = connector.start
    return found


_TYPES = {
    "Real": "real",
    "Integer": "integer",
    "Enumeration": "integer",
    "Boolean": "boolean",
    "String": "string",
}


def _conversion(conversion: Conversion) -> dict[str, Any]:
    return {
        "units": "ignored",
        "factor": conversion.factor,
        "offset": conversion.offset,
        "map": {int(key): int(value) for key, value in conversion.table},
    }


def _places(structure: Structure, resolved: Resolved) -> dict[Place, str]:
    places: dict[Place, str] = {(): structure.system.where}
    places |= {(key,): structure.times_where for key in ("start_time", "stop_time", "step_size")}
    for name, fmu in resolved.fmus.items():
        places["fmus", name] = fmu.where
        places |= {("fmus", name, "start", key): where for key, where in fmu.places.items()}
    places |= {("connectors", name): connector.where for name, connector in resolved.connectors.items()}
    for i, given in enumerate(_recorded(resolved)):
        owner = next(iter(given["map"])).partition(".")[0]
        places["inputs", i] = resolved.recordings[owner].where
        places |= {("inputs", i, "map", name): places["connectors", name] for name in given["map"]}
    places |= {("connections", i): wire.where for i, wire in enumerate(resolved.wires)}
    if structure.coupling is not None:
        for key in PARTS:
            places[(key,)] = f"{structure.coupling.where}: {key}"
    return places


def _notes(structure: Structure, data: Mapping[str, Any], is_foreign: bool, default_step: bool) -> list[str]:
    """What the file does not say and was chosen for it."""
    notes = []
    if data["name"] != structure.name:
        notes.append(f"the system {structure.name!r} is called {data['name']!r} here")
    step = f"{data['step_size']:.15g} s"
    if is_foreign:
        chosen = f"{step} (--step-size sets another)" if default_step else step
        notes.append(f"SSP names no order and no step size: stepped side by side, every {chosen}")
    times = {"startTime": structure.start_time, "stopTime": structure.stop_time}
    absent = [name for name, value in times.items() if value is None]
    if absent:
        span = f"from {data['start_time']:.15g} s to {data['stop_time']:.15g} s"
        notes.append(f"the file has no {' and no '.join(absent)}: stepped {span}")
    other = [name for name in structure.annotations if name != COUPLING]
    if other:
        notes.append(f"annotations of other tools are not read: {', '.join(other)}")
    return notes

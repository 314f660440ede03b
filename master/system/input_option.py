"""A recording that a command gets for the inputs of a system: which column drives which input."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Literal

from master.errors import ConfigError, DataError, expected
from master.fmi.description import Kind, Variable
from master.recording.time_column import time_name
from master.text.yaml_lines import Place

from .config import InputFile, LoadedConfig, MeasuredColumn
from .graph import System

OPTION = "--inputs"

_WITH_UNIT = re.compile(r"(.*\S)\s+\[([^\[\]]*)\]")
_RULE = (
    f"{OPTION}: between two samples a Real lies on the line, others keep the last one; "
    "the step from t to t + h uses the value at t"
)


@dataclass(frozen=True)
class _Header:
    """The head of a column: `text` is the whole, `name` what it names, in `unit`."""

    text: str
    name: str
    unit: str | None = None

    def column(self) -> MeasuredColumn:
        """Return what an entry of `inputs` says of the column."""
        return MeasuredColumn(column=self.text, unit=self.unit)


def with_input_file(loaded: LoadedConfig, path: Path, system: System) -> LoadedConfig:
    """
    Let a recording drive inputs of a system in addition to what its file says.

    Each column but that of the time is called as an input, `fmu.variable` or `system.connector`, the latter
    also without its system where no other has one of that name. A unit may follow, as in `root.u [mm]`.

    Raises:
        ConfigError: If the file cannot be read, or with every column that is no input.
    """
    from master.recording.tables import read_table

    try:
        texts = [*read_table(path).columns] or [""]
    except DataError as error:
        raise ConfigError([f"{OPTION}: {line}" for line in str(error).splitlines()]) from None
    known = dict(_inputs(system))
    headers = [_header(text, known) for text in texts]
    names = [header.name for header in headers]
    time = headers[names.index(time_name(names))]
    driving = _assigned([header for header in headers if header is not time], known, _short_names(system))
    columns: dict[Literal["linear", "hold"], dict[str, MeasuredColumn]] = {"linear": {}, "hold": {}}
    for signal, header in driving.items():
        columns["linear" if known[signal].kind is Kind.REAL else "hold"][signal] = header.column()
    entries = [
        InputFile(file=str(path), time=time.column(), map=own, interpolation=rule, at="start")
        for rule, own in columns.items()
        if own
    ]
    options: dict[Place, str] = {}
    for i, entry in enumerate(entries, start=len(loaded.config.inputs)):
        options["inputs", i] = OPTION
        for signal in entry.map:
            options["inputs", i, "map", signal] = f"{OPTION}: column {driving[signal].text!r}"
    return replace(
        loaded,
        config=loaded.config.model_copy(update={"inputs": (*loaded.config.inputs, *entries)}),
        notes=(*loaded.notes, _RULE),
        files={**loaded.files, str(path): path},
        options={**loaded.options, **options},
    )


def _inputs(system: System) -> Iterator[tuple[str, Variable]]:
    """Inputs of FMUs and of the whole system that a number can drive."""
    descriptions = {name: instance.description for name, instance in system.instances.items()}
    for owner, description in {**descriptions, **system.connectors}.items():
        for variable in description.variables:
            if variable.causality == "input" and variable.kind is not Kind.STRING:
                yield f"{owner}.{variable.name}", variable


def _short_names(system: System) -> dict[str, list[str]]:
    """Inputs of the whole system by their names without it."""
    found: dict[str, list[str]] = {}
    for owner, description in system.connectors.items():
        for variable in description.variables:
            if variable.causality == "input":
                found.setdefault(variable.name, []).append(f"{owner}.{variable.name}")
    return found


def _header(text: str, known: Mapping[str, Variable]) -> _Header:
    match = None if text in known else _WITH_UNIT.fullmatch(text)
    return _Header(text, text) if match is None else _Header(text, match[1], match[2])


def _assigned(
    headers: Iterable[_Header], known: Mapping[str, Variable], short: Mapping[str, list[str]]
) -> dict[str, _Header]:
    """Return the column of each input; ConfigError with every column that is none, or is one again."""
    found: dict[str, _Header] = {}
    problems: list[str] = []
    for header in headers:
        where = f"{OPTION}: column {header.text!r}"
        candidates = [header.name] if header.name in known else short.get(header.name, [])
        if len(candidates) > 1:
            problems.append(
                f"{where}: several inputs have this name, expected one of {', '.join(candidates)}"
            )
        elif not candidates:
            choices = expected(header.name, [*known])
            problems.append(f"{where}: no such input, got {header.name!r}, {choices}")
        elif candidates[0] in found:
            first = found[candidates[0]].text
            problems.append(f"{where}: drives {candidates[0]!r} as {first!r} does, expected one column")
        else:
            found[candidates[0]] = header
    if not found and not problems:
        problems.append(f"{OPTION}: no columns but that of the time, expected one for each input to drive")
    if problems:
        raise ConfigError(problems)
    return found

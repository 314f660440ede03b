"""A system as SSP describes it: typed, with the place of everything in its file. Nothing is resolved yet."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

from master.fmi.description import Description
from master.fmi.units import Unit

INPUTS = ("input", "parameter", "structuralParameter")
OUTPUTS = ("output", "calculatedParameter", "constant", "local")


@dataclass(frozen=True)
class Scope:
    """Units and enumerations (numbers of their items) that one file defines."""

    units: Mapping[str, Unit] = field(default_factory=dict)
    enumerations: Mapping[str, Mapping[str, int]] = field(default_factory=dict)


@dataclass(frozen=True)
class DataType:
    """
    Type of a connector or a dictionary's entry.

    `kind` is Real, Integer, Boolean, String, Enumeration, Binary or Clock, whatever the width; `items` are
    those of its enumeration.
    """

    kind: str
    unit: Unit | None = None
    items: Mapping[str, int] = field(default_factory=dict)


@dataclass(frozen=True)
class Linear:
    """factor * value + offset."""

    factor: float
    offset: float
    where: str


@dataclass(frozen=True)
class Table:
    """Values and what takes their place; `kind` is Boolean, Integer or Enumeration (by names of items)."""

    kind: str
    entries: Mapping[str, str]
    where: str


Transformation = Linear | Table


@dataclass(frozen=True)
class Connector:
    """
    A connector of a component, a system or a dictionary's reference.

    `shape` are the lengths along the dimensions that it declares, None where another connector has one.
    """

    name: str
    kind: str
    type: DataType | None
    where: str
    shape: tuple[int | None, ...] = ()


@dataclass(frozen=True)
class End:
    """One end of a connection; `element` is None for a connector of the system itself."""

    element: str | None
    connector: str


@dataclass(frozen=True)
class Link:
    """A connection as it is written; its direction follows from the connectors."""

    start: End
    end: End
    converts_units: bool
    transformation: Transformation | None
    where: str


@dataclass(frozen=True)
class Given:
    """A value of a parameter set: numbers, truths and texts as such, an enumeration by its item's name."""

    name: str
    kind: str
    values: tuple[float | int | bool | str, ...]
    unit: Unit | None
    items: Mapping[str, int]
    where: str


@dataclass(frozen=True)
class Renaming:
    """An entry of a parameter mapping."""

    source: str
    target: str
    converts_units: bool
    transformation: Transformation | None
    where: str


@dataclass(frozen=True)
class Binding:
    """Values for an element; `renamings` is None without a mapping: all go by their own names."""

    prefix: str
    values: tuple[Given, ...]
    renamings: tuple[Renaming, ...] | None
    where: str


@dataclass(frozen=True)
class Component:
    """An FMU."""

    name: str
    connectors: Mapping[str, Connector]
    bindings: tuple[Binding, ...]
    file: Path
    fmu: Description
    where: str


@dataclass(frozen=True)
class Recording:
    """A table of signals over the time [s] in column `time`; `file` is on disk, `member` in the archive."""

    name: str
    connectors: Mapping[str, Connector]
    file: Path
    member: str
    time: str
    where: str


@dataclass(frozen=True)
class Dictionary:
    """Signals that references in several systems share."""

    name: str
    entries: Mapping[str, DataType]
    where: str


@dataclass(frozen=True)
class Reference:
    """A place in a system where signals of a dictionary go in and out."""

    name: str
    dictionary: str
    connectors: Mapping[str, Connector]
    where: str


@dataclass(frozen=True)
class SubSystem:
    """A system with its elements; one that another file describes is no different."""

    name: str
    connectors: Mapping[str, Connector]
    bindings: tuple[Binding, ...]
    elements: Mapping[str, Component | Recording | SubSystem | Reference]
    links: tuple[Link, ...]
    dictionaries: Mapping[str, Dictionary]
    where: str


@dataclass(frozen=True)
class Annotation:
    """What this project's export adds, as text, and its place."""

    text: str
    where: str


@dataclass(frozen=True)
class Structure:
    """
    A file `*.ssd` with all that it refers to.

    `start_time` and `stop_time` [s] are None where the file does not say; `annotations` are the types of
    those that other tools left.
    """

    name: str
    description: str
    system: SubSystem
    start_time: float | None
    stop_time: float | None
    times_where: str
    coupling: Annotation | None
    annotations: tuple[str, ...]
    notes: tuple[str, ...]

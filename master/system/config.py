"""A system description: the YAML form as frozen data, all faults reported at once."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import (
    AfterValidator,
    BaseModel,
    ConfigDict,
    Discriminator,
    Field,
    Tag,
    ValidationError,
    ValidationInfo,
    field_validator,
    model_validator,
)

from master.errors import ConfigError, expected
from master.fmi.value_types import Value
from master.text.yaml_lines import Document, Place, read_yaml

MOST_DELAY = 10**7  # ticks; each older value is kept in memory
MOST_TICKS = 2**53  # beyond it a double does not tell one tick from the next

ParameterValues = dict[str, Value]


def finite(value: float) -> float:
    """Give a finite number back; ValueError for any other."""
    if not math.isfinite(value):
        raise ValueError("not a finite number")
    return value


def _signal(text: str) -> str:
    instance, _, variable = text.partition(".")
    if not (instance and variable):
        raise ValueError("not an 'instance.variable'")
    return text


def _name(text: str) -> str:
    if not text or any(c.isspace() or c in ".<>" for c in text):
        raise ValueError("not a name without spaces, '.', '<' and '>'")
    return text


Name = Annotated[str, AfterValidator(_name)]
Signal = Annotated[str, AfterValidator(_signal)]
Finite = Annotated[float, AfterValidator(finite)]
Ticks = Annotated[int, Field(ge=0, le=MOST_DELAY)]
Seconds = Annotated[float, Field(gt=0.0), AfterValidator(finite)]


class Part(BaseModel):
    """Base of all parts: no unknown keys, no changes after reading."""

    model_config = ConfigDict(extra="forbid", frozen=True, populate_by_name=True)


class FmuEntry(Part):
    """One FMU: a model's name or a path, its values, and how often it steps."""

    source: str
    parameters: ParameterValues = {}
    start: ParameterValues = {}
    every: Annotated[int, Field(ge=1)] = 1


class Connection(Part):
    """A wire; `delay` adds whole steps, `extrapolation` is the order of a polynomial one step on."""

    source: Signal = Field(alias="from")
    target: Signal = Field(alias="to")
    delay: Ticks = 0
    extrapolation: Annotated[int, Field(ge=0, le=2)] = 0
    tolerance: Annotated[float, Field(gt=0.0)] | None = None


class IteratedGroup(Part):
    """FMUs that step one after the other, again and again from saved states, until their wires agree."""

    iterate: Annotated[list[str], Field(min_length=1)]
    tolerance: Annotated[float, Field(gt=0.0)] = 1e-9
    maximum: Annotated[int, Field(ge=1)] = 50


def _form(entry: Any) -> str:
    if isinstance(entry, list):
        return "<side by side>"
    return "<iterated>" if isinstance(entry, dict | IteratedGroup) else "<one>"


OrderEntry = Annotated[
    Annotated[str, Tag("<one>")]
    | Annotated[list[str], Tag("<side by side>")]
    | Annotated[IteratedGroup, Tag("<iterated>")],
    Discriminator(_form),
]


class Coupling(Part):
    """The order in which the FMUs step; an inner list steps side by side, `{iterate: [...]}` iterates."""

    order: list[OrderEntry] | None = None


class Compare(Part):
    """What a run is judged by: the simulated motion, its reproduction and the reference."""

    signal: Signal
    reproduced: Signal | None = None
    reference: Signal | None = None
    offset: Annotated[float, Field(gt=0.0), AfterValidator(finite)]
    force: Signal | None = None
    reference_force: Signal | None = None


class Event(Part):
    """Something that happens in a run, at a time [s] or when `instance.variable > number` comes true."""

    at: Finite | None = None
    when: str | None = None
    duration: Seconds | None = Field(None, alias="for")
    set: dict[Signal, Value] = {}
    freeze: list[Signal] = []
    drop: list[Signal] = []
    offset: dict[Signal, Finite] = {}
    delay: dict[Signal, Ticks] = {}
    jitter: dict[Signal, Ticks] = {}
    seed: Annotated[int, Field(ge=1, lt=2147483647)] = 1

    @field_validator("freeze", "drop", mode="before")
    @classmethod
    def _one_or_more(cls, value: Any) -> Any:
        return [value] if isinstance(value, str) else value

    @model_validator(mode="after")
    def _one_occasion(self) -> Event:
        if (self.at is None) == (self.when is None):
            raise ValueError("an event has either 'at' or 'when'")
        return self


class PhaseLead(Part):
    """
    The DPDC of an FMU, designed from the plant before the run; ranges of m_s, m_e, k_m, k_p.

    `amplitude` is what the lead's gain at its frequency makes up for: nothing (paper), or the plant's.
    """

    design: Literal["auto"]
    fmu: str = "compensator"
    amplitude: Literal["paper", "plant"] = "paper"
    ranges: dict[Literal["m_s", "m_e", "k_m", "k_p"], tuple[float, float]] = {}


class Config(Part):
    """A whole system."""

    name: str
    description: str = ""
    step_size: Seconds = 1e-3
    start_time: Finite = 0.0
    stop_time: Seconds
    fmus: Annotated[dict[Name, FmuEntry], Field(min_length=1)]
    coupling: Coupling = Coupling()
    connections: list[Connection] = []
    variants: dict[str, dict[str, ParameterValues]] = {}
    compare: Compare | None = None
    dpdc: PhaseLead | None = None
    events: list[Event] = []
    limits: dict[Signal, Annotated[float, Field(gt=0.0)]] = {}

    @field_validator("stop_time")
    @classmethod
    def _whole_steps(cls, stop_time: float, info: ValidationInfo) -> float:
        if not {"step_size", "start_time"} <= info.data.keys():
            return stop_time
        ticks = (stop_time - info.data["start_time"]) / info.data["step_size"]
        if not ticks > 0.0:
            raise ValueError("not after start_time")
        if ticks > MOST_TICKS:
            raise ValueError(f"{ticks:.3g} steps, expected at most {MOST_TICKS:.3g}")
        if abs(ticks - round(ticks)) > 1e-6 * max(1.0, ticks * 1e-3):
            raise ValueError(f"{ticks:.9g} steps after start_time, expected a whole number")
        return stop_time

    @property
    def n_ticks(self) -> int:
        """Number of communication steps."""
        return round((self.stop_time - self.start_time) / self.step_size)


class LoadedConfig(Part):
    """A configuration with the file it came from, for messages."""

    model_config = ConfigDict(arbitrary_types_allowed=True, frozen=True)

    config: Config
    document: Document

    @property
    def folder(self) -> Path:
        """Folder that relative paths start from."""
        return self.document.path.parent

    def where(self, *place: str | int) -> str:
        """Name a place in the file."""
        return self.document.where(place)


def load_config(path: Path) -> LoadedConfig:
    """
    Read and validate a system description.

    Raises:
        ConfigError: With every fault of the file.
    """
    document = read_yaml(path)
    if not isinstance(document.data, dict):
        got = type(document.data).__name__
        raise ConfigError(
            [f"{path}:1: file: not a system, got {got}, expected a mapping with name, fmus, ..."]
        )
    try:
        return LoadedConfig(config=Config.model_validate(document.data), document=document)
    except ValidationError as error:
        raise ConfigError(_problems(document, error)) from None


def with_stop_time(config: Config, stop_time: float) -> Config:
    """Replace the stop time [s]; ConfigError if it does not fit the step size."""
    try:
        return Config.model_validate(config.model_dump(by_alias=True) | {"stop_time": stop_time})
    except ValidationError as error:
        raise ConfigError(f"--stop-time: {_text(e)}" for e in error.errors()) from None


def _problems(document: Document, error: ValidationError) -> list[str]:
    merged: dict[Place, str] = {}
    for fault in error.errors():
        place = _data_place(document.data, fault["loc"])
        merged.setdefault(place, f"{document.where(place)}: {_text(fault)}")
    return list(merged.values())


def _data_place(data: Any, location: Place) -> Place:
    """Drop from pydantic's location what names a type and not a key of the file."""
    place: list[str | int] = []
    for key in location:
        if isinstance(key, str) and key.startswith("<"):
            continue
        inside = (isinstance(data, dict) and key in data) or (
            isinstance(data, list) and isinstance(key, int) and key < len(data)
        )
        if inside:
            data = data[key]
        elif place and not isinstance(data, dict):
            continue
        place.append(key)
    return tuple(place)


_KNOWN: dict[str, type[Part]] = {
    "fmus": FmuEntry,
    "connections": Connection,
    "coupling": Coupling,
    "compare": Compare,
    "dpdc": PhaseLead,
    "events": Event,
}


def _text(fault: Any) -> str:
    kind, place, got = fault["type"], fault["loc"], fault.get("input")
    if kind == "missing":
        return "missing, expected a value"
    if kind == "extra_forbidden":
        part = Config if len(place) == 1 else _KNOWN.get(str(place[0]), Config)
        keys = [f.alias or name for name, f in part.model_fields.items()]
        return f"unknown key, {expected(str(place[-1]), keys)}"
    message = str(fault["msg"]).removeprefix("Value error, ")
    if kind == "value_error" and not place:
        return message
    shown = repr(got) if isinstance(got, str | int | float | bool | None) else type(got).__name__
    return f"{message[0].lower() + message[1:]}, got {shown}"

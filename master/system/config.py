"""A system description: the YAML form as frozen data, all faults reported at once."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from fractions import Fraction
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import (
    Field,
    ValidationError,
    ValidationInfo,
    field_validator,
    model_validator,
)

from master.coupling.methods.catalogue import OrderEntry
from master.errors import ConfigError, Problem
from master.fmi.units import Unit
from master.isolation.options import DEADLINE, STOP, Isolation
from master.text.fields import (
    Finite,
    GivenSetting,
    InstanceName,
    Integer,
    Name,
    OrEmpty,
    ParameterValues,
    Positive,
    Seconds,
    Section,
    Signal,
    SignalKey,
    Ticks,
)
from master.text.scalar import float_of
from master.text.schema import ONE_OR_MORE
from master.text.validation import problems_of, validate
from master.text.yaml_lines import Document, Place, read_yaml

from .grid import ticks_between

MOST_TICKS = 2**53  # beyond it a double does not tell one tick from the next
MOST_EVERY = 10**9  # ticks
MOST_ITERATIONS = 10**6
MOST_DEADLINE = 10**6  # s
MOST_MEMORY = 2**24  # MB
FINEST = 0.25  # largest distance of two neighbouring doubles at the run's times, in steps
UNKNOWN_SOURCE = "<unknown>"  # of an FMU whose own source is missing or wrong, while the rest is checked


class FmuEntry(Section):
    """
    One FMU: a model's name or a path, its values, how often it steps, whether it has a process of its own.

    `deadline` [s] is the longest time of a call and `memory` [MB] what the FMU may allocate; with `on_fault:
    hold` its last values are held where it fails. An FMU with one of these is isolated: nothing else can keep
    it to them.
    """

    source: str = Field(examples=["spacecraft"])
    parameters: ParameterValues = {}
    start: ParameterValues = {}
    every: Annotated[Integer, Field(ge=1, le=MOST_EVERY)] = 1
    isolate: bool | None = None
    on_fault: Literal["stop", "hold"] | None = None
    deadline: Annotated[Seconds, Field(le=MOST_DEADLINE)] | None = None
    memory: Annotated[Integer, Field(ge=1, le=MOST_MEMORY)] | None = None

    @model_validator(mode="after")
    def _isolated_for_its_limits(self) -> FmuEntry:
        limits = [key for key in ("on_fault", "deadline", "memory") if getattr(self, key) is not None]
        if self.isolate is False and limits:
            raise ValueError(f"{limits[0]} of an FMU that is not isolated, expected isolate: true")
        return self

    def isolation(self) -> Isolation | None:
        """How the FMU is isolated, None if it is not."""
        limits = (self.on_fault, self.deadline, self.memory)
        if not self.isolate and all(limit is None for limit in limits):
            return None
        return Isolation(
            deadline=self.deadline or DEADLINE, memory=self.memory, on_fault=self.on_fault or STOP
        )

    @classmethod
    def stand_in(cls, key: str, data: Mapping[str, Any]) -> Any:
        return UNKNOWN_SOURCE if key == "source" else None


class Connection(Section):
    """
    A wire; `delay` adds whole steps, `extrapolation` is the order of a polynomial one step on.

    The target gets `factor` times the value plus `offset`, in its own unit; a `map` replaces values of an
    integer, a Boolean or an enumeration first and keeps those that it does not name. `units: ignored`
    takes the number as it is, whatever the units of both ends.
    """

    source: Signal = Field(alias="from", examples=["spacecraft.s_des"])
    target: Signal = Field(alias="to", examples=["contact.s_act"])
    units: Literal["converted", "ignored"] = "converted"
    factor: Finite = 1.0
    offset: Finite = 0.0
    map: Annotated[dict[Integer, Integer], OrEmpty] = {}
    delay: Ticks = 0
    extrapolation: Annotated[Integer, Field(ge=0, le=2)] = 0
    tolerance: Positive | None = None


class SystemConnector(Section):
    """
    An input, a parameter or an output of the whole system; connections lead from it or to it as to an FMU.

    `unit` converts as that of an FMU's variable, `items` are those of an enumeration, `shape` the lengths of
    an array along each dimension. `start` is the value of an input or a parameter; where it is not given,
    the FMUs keep theirs.
    """

    kind: Literal["input", "parameter", "output"] = Field(examples=["output"])
    type: Literal["real", "integer", "boolean", "string"] = "real"
    unit: str | None = None
    items: Annotated[dict[str, Integer], OrEmpty] = {}
    shape: list[Annotated[Integer, Field(ge=1)]] = []
    start: GivenSetting | None = None


class Coupling(Section):
    """The order in which the FMUs step; the methods of `master/coupling/methods` say how it is written."""

    order: list[OrderEntry] | None = None


class Compare(Section):
    """What a run is judged by: the simulated motion, its reproduction and the reference."""

    signal: Signal = Field(examples=["spacecraft.s_des"])
    reproduced: Signal | None = None
    reference: Signal | None = None
    offset: Seconds = Field(examples=[0.01])
    force: Signal | None = None
    reference_force: Signal | None = None


class Event(Section):
    """Something that happens in a run, at a time [s] or when `instance.variable > number` comes true."""

    at: Finite | None = None
    when: str | None = None
    duration: Seconds | None = Field(None, alias="for")
    set: Annotated[dict[SignalKey, GivenSetting], OrEmpty] = {}
    freeze: list[Signal] = Field([], json_schema_extra=ONE_OR_MORE)
    drop: list[Signal] = Field([], json_schema_extra=ONE_OR_MORE)
    offset: Annotated[dict[SignalKey, Finite], OrEmpty] = {}
    delay: Annotated[dict[SignalKey, Ticks], OrEmpty] = {}
    jitter: Annotated[dict[SignalKey, Ticks], OrEmpty] = {}
    seed: Annotated[Integer, Field(ge=1, lt=2147483647)] = 1

    @field_validator("freeze", "drop", mode="before")
    @classmethod
    def _one_or_more(cls, value: Any) -> Any:
        return [value] if isinstance(value, str) else value

    @model_validator(mode="after")
    def _one_occasion(self) -> Event:
        if (self.at is None) == (self.when is None):
            raise ValueError("an event has either 'at' or 'when'")
        return self


class MeasuredColumn(Section):
    """A column of a recording and its unit (None: the one that is expected)."""

    column: str
    unit: str | None = None


class InputFile(Section):
    """
    A recording that drives inputs which no wire does.

    `array` names a table of an NPZ or MAT. Between its samples an input holds the last one, or lies on the
    line to the next one. A step from t to t + h uses the value `at` its end or its start.
    """

    file: str
    time: MeasuredColumn
    map: Annotated[dict[SignalKey, MeasuredColumn], Field(min_length=1)]
    interpolation: Literal["hold", "linear"] = "hold"
    at: Literal["start", "end"] = "end"
    array: str | None = None


class Record(Section):
    """What goes to the result files: these outputs (all, if none is named), every n-th row from the first."""

    signals: list[Signal] = Field([], json_schema_extra=ONE_OR_MORE)
    every: Annotated[Integer, Field(ge=1, le=MOST_EVERY)] = 1

    @field_validator("signals", mode="before")
    @classmethod
    def _one_or_more(cls, value: Any) -> Any:
        return [value] if isinstance(value, str) else value


class PhaseLead(Section):
    """
    The DPDC of an FMU, designed from the plant before the run; ranges of m_s, m_e, k_m, k_p.

    `amplitude` is what the lead's gain at its frequency makes up for: nothing (paper), or the plant's.
    """

    design: Literal["auto"] = Field(examples=["auto"])
    fmu: str = "compensator"
    amplitude: Literal["paper", "plant"] = "paper"
    ranges: Annotated[dict[Literal["m_s", "m_e", "k_m", "k_p"], tuple[Finite, Finite]], OrEmpty] = {}


_LATE = 10**9  # ticks: no event is after it


def _late(data: Mapping[str, Any]) -> float | None:
    """Stop time that fits the step size; None where that is wrong too."""
    try:
        return float_of(data.get("start_time", 0.0)) + _LATE * float_of(data.get("step_size", 1e-3))
    except ValueError:
        return None


Variant = Annotated[dict[InstanceName, ParameterValues], OrEmpty]


class Config(Section):
    """A whole system."""

    name: Name = Field(examples=["my_system"])
    description: str = ""
    step_size: Seconds = 1e-3
    start_time: Finite = 0.0
    stop_time: Finite = Field(examples=[10.0])
    fmus: Annotated[
        dict[InstanceName, FmuEntry],
        Field(min_length=1, examples=[{"spacecraft": {"source": "spacecraft"}}]),
    ]
    coupling: Coupling = Coupling()
    connections: list[Connection] = []
    connectors: dict[SignalKey, SystemConnector] = {}
    variants: dict[Name, Variant] = {}
    compare: Compare | None = None
    dpdc: PhaseLead | None = None
    events: list[Event] = []
    stop_when: list[str] = Field([], json_schema_extra=ONE_OR_MORE)
    inputs: list[InputFile] = Field([], json_schema_extra=ONE_OR_MORE)
    limits: dict[SignalKey, Positive] = {}
    record: Record = Record(signals=[])
    plots: list[Annotated[list[Signal], Field(min_length=1)]] | None = None

    @classmethod
    def stand_in(cls, key: str, data: Mapping[str, Any]) -> Any:
        if key == "stop_time":
            return _late(data)
        return "system" if key == "name" else None

    @field_validator("stop_time")
    @classmethod
    def _whole_steps(cls, stop_time: float, info: ValidationInfo) -> float:
        if not {"step_size", "start_time"} <= info.data.keys():
            return stop_time
        ticks = ticks_between(info.data["start_time"], stop_time, info.data["step_size"])
        if not ticks > 0:
            raise ValueError(f"not after start_time, expected more than {info.data['start_time']:g}")
        if ticks > MOST_TICKS:
            raise ValueError(
                f"{float(min(ticks, Fraction(10**300))):.3g} steps, expected at most {MOST_TICKS:.3g}"
            )
        if ticks < Fraction(1, 2) or abs(ticks - round(ticks)) > 1e-6 * max(1.0, float(ticks) * 1e-3):
            raise ValueError(f"{float(ticks):.9g} steps after start_time, expected a whole number")
        distance = math.ulp(max(abs(info.data["start_time"]), abs(stop_time)))
        if distance > FINEST * info.data["step_size"]:
            raise ValueError(
                f"times {distance:.3g} s apart are the nearest that a double holds there, "
                f"expected a step_size of at least {distance / FINEST:.3g}"
            )
        return stop_time

    @field_validator("stop_when", mode="before")
    @classmethod
    def _one_condition_or_more(cls, value: Any) -> Any:
        return [value] if isinstance(value, str) else value

    @field_validator("inputs", mode="before")
    @classmethod
    def _one_file_or_more(cls, value: Any) -> Any:
        return [value] if isinstance(value, dict) else value

    @property
    def n_ticks(self) -> int:
        """Number of communication steps."""
        return round(ticks_between(self.start_time, self.stop_time, self.step_size))


@dataclass(frozen=True)
class LoadedConfig:
    """
    A configuration with the file it came from, for messages, and notes on how that was read.

    `problems` are faults of the file; with any of them, `config` is what is left without them.
    `is_designed`: the values that a design (`dpdc: {design: auto}`) gives are among its values already.
    `units` are those that the file itself defines for connectors of the system, by the connector; `files` are
    recordings that were unpacked from it, by the name that `inputs` has for them. `options` names what gave
    the places that the file does not have.
    """

    config: Config
    document: Document
    problems: list[Problem] = field(default_factory=list)
    notes: tuple[str, ...] = ()
    is_designed: bool = False
    units: Mapping[str, Unit] = field(default_factory=dict)
    files: Mapping[str, Path] = field(default_factory=dict)
    options: Mapping[Place, str] = field(default_factory=dict)

    @property
    def folder(self) -> Path:
        """Folder that relative paths start from."""
        return self.document.path.parent

    def where(self, *place: str | int) -> str:
        """Name a place in the file, or what gave it."""
        nearest = (place[:n] for n in range(len(place), 0, -1))
        option = next((self.options[known] for known in nearest if known in self.options), None)
        return self.document.where(place) if option is None else option


def read_config(path: Path) -> LoadedConfig:
    """
    Read a system description as far as it is right; what is wrong is in `problems`.

    Raises:
        ConfigError: If too little is right to check the rest.
    """
    found = validate(Config, read_yaml(path), "system")
    if found.model is None:
        raise ConfigError(found.problems)
    return LoadedConfig(found.model, found.document, found.problems)


def load_config(path: Path) -> LoadedConfig:
    """
    Read and validate a system description.

    Raises:
        ConfigError: With every fault of the file.
    """
    loaded = read_config(path)
    if loaded.problems:
        raise ConfigError(loaded.problems)
    return loaded


def with_times(config: Config, step_size: float | None, stop_time: float | None) -> Config:
    """Replace the step size and the stop time [s] that are given; ConfigError if they do not fit."""
    given = {"step_size": step_size, "stop_time": stop_time}
    changes = {key: value for key, value in given.items() if value is not None}
    try:
        Config.model_validate(
            {
                "name": config.name,
                "step_size": config.step_size,
                "start_time": config.start_time,
                "stop_time": config.stop_time,
                "fmus": config.fmus,
                **changes,
            }
        )
    except ValidationError as error:
        options = ", ".join(f"--{key.replace('_', '-')}" for key in changes)
        raise ConfigError(problems_of(error, options)) from None
    return config.model_copy(update=changes)

"""A case: a system, recordings, what drives and what is compared; the YAML form as frozen data."""

from __future__ import annotations

import os
import re
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import BeforeValidator, Field, ValidationError, model_validator

from master.errors import ConfigError, DataError, expected
from master.system.config import FmuEntry, LoadedConfig, Part, Signal
from master.text.yaml_lines import Document, read_yaml

from .split import PARTS

_VARIABLE = re.compile(r"\$\{(\w+)\}")


class RecordingEntry(Part):
    """A file, or some rows of it."""

    file: str
    array: str | None = None
    rows: tuple[Annotated[int, Field(ge=0)], int] | None = None

    @model_validator(mode="after")
    def _ordered(self) -> RecordingEntry:
        if self.rows is not None and self.rows[1] <= self.rows[0]:
            raise ValueError(f"rows: got {list(self.rows)}, expected [first, end] with first below end")
        return self


def _recording(value: Any) -> Any:
    return {"file": value} if isinstance(value, str) else value


def _names_of_effects(value: Any) -> Any:
    return [value] if isinstance(value, str) and value != "all" else value


class TimeEntry(Part):
    """The column of the time, or the period [s] of a recording without one."""

    column: str | None = None
    unit: str = "s"
    offset: float = 0.0
    period: Annotated[float, Field(gt=0.0)] | None = None
    jitter: Annotated[float, Field(gt=0.0)] = 0.05

    @model_validator(mode="after")
    def _one(self) -> TimeEntry:
        if self.column is None and self.period is None:
            raise ValueError("expected a column or a period")
        return self


class SignalEntry(Part):
    """A column as a signal: sign * scale * column in `unit`; or the rate of another signal."""

    column: str | None = None
    unit: str = "1"
    scale: float = 1.0
    sign: Literal[-1, 1] = 1
    offset: float = 0.0
    minus: str | None = None
    remove_mean: bool = False
    lowpass: Annotated[float, Field(gt=0.0)] | None = None
    rate_of: str | None = None

    @model_validator(mode="after")
    def _one(self) -> SignalEntry:
        if (self.column is None) == (self.rate_of is None):
            raise ValueError("a signal has either 'column' or 'rate_of'")
        if self.scale == 0.0:
            raise ValueError("scale: got 0, expected another number")
        return self


def _input(value: Any) -> Any:
    return {"signal": value} if isinstance(value, str) else value


class InputEntry(Part):
    """Measured signal that drives an FMU; `at`: the row at the start or at the end of the step."""

    signal: str
    at: Literal["start", "end"] | None = None


class RefitEntry(Part):
    """Bounds of a parameter that may be wrong; `spread` is the deviation of a prior around its value."""

    low: float
    high: float
    spread: Annotated[float, Field(gt=0.0)] | None = None

    @model_validator(mode="after")
    def _ordered(self) -> RefitEntry:
        if not self.low < self.high:
            raise ValueError(f"low is not below high, got {self.low!r} and {self.high!r}")
        return self


class SplitEntry(Part):
    """Use of blocks in time order, or of whole recordings; `sealed` recordings beside blocks."""

    blocks: list[str] | None = None
    guard: Annotated[float, Field(ge=0.0)] = 0.2
    fit: list[str] = Field([])
    select: list[str] = Field([])
    sealed: list[str] = Field([])

    @model_validator(mode="after")
    def _complete(self) -> SplitEntry:
        if self.blocks is None:
            missing = [part for part in PARTS if not getattr(self, part)]
            if missing:
                raise ValueError(
                    f"expected blocks, or recordings for fit, select and sealed, got no {missing[0]}"
                )
            return self
        wrong = sorted({b for b in self.blocks if b not in PARTS})
        missing = [p for p in PARTS if p not in self.blocks and not (p == "sealed" and self.sealed)]
        if wrong or missing:
            raise ValueError(f"blocks: got {wrong or 'no ' + missing[0]}, expected fit, select and sealed")
        return self


class ReplayEntry(Part):
    """How recordings are replayed."""

    oversample: Annotated[int, Field(ge=1, le=20)] = 1
    settle: Annotated[float, Field(ge=0.0)] = 0.0
    windows: dict[str, Annotated[float, Field(gt=0.0)]] = Field({})
    cut: Annotated[int, Field(ge=0)] = 0
    decimate: Annotated[int, Field(ge=1, le=13)] = 1


class Case(Part):
    """A whole case."""

    name: str
    description: str = ""
    system: str | None = None
    variant: str | None = None
    fmus: dict[str, FmuEntry] = Field({})
    recordings: Annotated[
        dict[str, Annotated[RecordingEntry, BeforeValidator(_recording)]], Field(min_length=1)
    ]
    time: TimeEntry
    signals: Annotated[dict[str, SignalEntry], Field(min_length=1)]
    inputs: Annotated[dict[Signal, Annotated[InputEntry, BeforeValidator(_input)]], Field(min_length=1)]
    compared: Annotated[dict[Signal, str], Field(min_length=1)]
    refit: dict[Signal, RefitEntry] = Field({})
    set: dict[Signal, float | int | str | bool] = Field({})
    starts: dict[Signal, tuple[float, float]] = Field({})
    slots: dict[Signal, Annotated[Literal["all"] | list[str], BeforeValidator(_names_of_effects)]] = Field({})
    split: SplitEntry
    replay: ReplayEntry = ReplayEntry.model_validate({})

    @model_validator(mode="after")
    def _one_system(self) -> Case:
        if (self.system is None) == (not self.fmus):
            raise ValueError("a case has either 'system' or 'fmus'")
        return self


class LoadedCase(Part):
    """A case with the file it came from."""

    model_config = LoadedConfig.model_config

    case: Case
    document: Document

    def where(self, *place: str | int) -> str:
        """Name a place in the file."""
        return self.document.where(place)

    def file(self, entry: RecordingEntry) -> Path:
        """
        Path of a recording, from the folder of the case or the variable in its name.

        Raises:
            DataError: If a variable is not set.
        """
        return self.document.path.parent / filled(entry.file)


def filled(text: str) -> str:
    """
    Replace `${NAME}` by environment variables.

    Raises:
        DataError: With every variable that is not set.
    """
    missing = [name for name in dict.fromkeys(_VARIABLE.findall(text)) if not os.environ.get(name)]
    if missing:
        raise DataError(
            "\n".join(
                f"{text}: environment variable {name}: not set, got none, expected the folder that holds the "
                f"recordings (export {name}=...), or a path from the folder of the case"
                for name in missing
            )
        )
    return _VARIABLE.sub(lambda m: os.environ[m[1]], text)


def load_case(path: Path) -> LoadedCase:
    """
    Read a case and check what can be checked without the system.

    Raises:
        ConfigError: With every fault of the file.
    """
    document = read_yaml(path)
    if not isinstance(document.data, dict):
        got = type(document.data).__name__
        raise ConfigError(
            [f"{path}:1: file: not a case, got {got}, expected a mapping with system, recordings, ..."]
        )
    try:
        loaded = LoadedCase(case=Case.model_validate(document.data), document=document)
    except ValidationError as error:
        raise ConfigError(_problems(document, error)) from None
    problems = _names(loaded)
    if problems:
        raise ConfigError(problems)
    return loaded


def _problems(document: Document, error: ValidationError) -> list[str]:
    found: dict[str, None] = {}
    for fault in error.errors():
        place = tuple(k for k in fault["loc"] if k not in ("all", "list[str]", "literal['all']"))
        found.setdefault(f"{document.where(place)}: {_text(fault)}")
    return list(found)


def _text(fault: Any) -> str:
    if fault["type"] == "missing":
        return "missing, expected a value"
    if fault["type"] == "extra_forbidden":
        known = Case.model_fields if len(fault["loc"]) == 1 else ()
        return f"unknown key, {expected(str(fault['loc'][-1]), known)}" if known else "unknown key, got one"
    message, got = str(fault["msg"]).removeprefix("Value error, "), fault.get("input")
    if isinstance(got, str | int | float | bool | None):
        return f"{message[0].lower() + message[1:]}, got {got!r}"
    return message


def _names(loaded: LoadedCase) -> list[str]:
    """Faults of names that must exist in the case itself."""
    case, where = loaded.case, loaded.where
    uses = [(where("inputs", key), e.signal) for key, e in case.inputs.items()]
    uses += [(where("compared", key), name) for key, name in case.compared.items()]
    for name, s in case.signals.items():
        uses += [(where("signals", name, k), v) for k, v in (("minus", s.minus), ("rate_of", s.rate_of)) if v]
    problems = [
        f"{place}: no such signal, got {name!r}, {expected(name, case.signals)}"
        for place, name in uses
        if name not in case.signals
    ]
    for part in PARTS:
        problems += [
            f"{where('split', part, i)}: no such recording, got {name!r}, {expected(name, case.recordings)}"
            for i, name in enumerate(getattr(case.split, part))
            if name not in case.recordings
        ]
    return problems + _uses(loaded)


def _uses(loaded: LoadedCase) -> list[str]:
    """Recordings that are used twice, not at all, or all sealed."""
    split, names = loaded.case.split, loaded.case.recordings
    used = [name for part in PARTS for name in getattr(split, part)]
    place = loaded.where("split")
    problems = [
        f"{place}: {name!r} stands {used.count(name)} times, expected once"
        for name in dict.fromkeys(used)
        if used.count(name) > 1
    ]
    if split.blocks is None:
        idle = [name for name in names if name not in used]
        problems += [f"{place}: {name!r} is used for nothing, expected a part for it" for name in idle]
    elif set(names) <= set(split.sealed):
        problems.append(f"{place}: all recordings are sealed, expected one to cut into blocks")
    return problems

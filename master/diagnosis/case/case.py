"""A case: a system, recordings, what drives and what is compared; the YAML form as frozen data."""

from __future__ import annotations

import os
import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import BeforeValidator, Field, model_validator

from master.errors import ConfigError, DataError, Problem, nearest
from master.installation import configuration
from master.system.config import FmuEntry
from master.text.fields import (
    Boolean,
    Finite,
    GivenValue,
    InstanceName,
    Integer,
    Name,
    OrEmpty,
    Positive,
    Seconds,
    Section,
    SignalKey,
)
from master.text.scalar import integer_of
from master.text.schema import OrText
from master.text.validation import validate
from master.text.yaml_lines import Document, Place, read_yaml

from .split import PARTS

_VARIABLE = re.compile(r"\$\{(\w+)\}")


def _named_by_number(value: Any) -> Any:
    """Take a number that YAML reads as one for the name of a column: 0, 1, ... of an array."""
    return str(value) if isinstance(value, int) and not isinstance(value, bool) else value


ColumnName = Annotated[str, BeforeValidator(_named_by_number)]


class TimeEntry(Section):
    """The column of the time, or the period [s] of rows without one; `gaps: split` cuts at gaps."""

    column: ColumnName | None = None
    unit: str = "s"
    offset: Finite = 0.0
    period: Seconds | None = None
    jitter: Positive = 0.05
    gaps: Literal["refuse", "split"] = "refuse"

    @model_validator(mode="after")
    def _one(self) -> TimeEntry:
        if self.column is None and self.period is None:
            raise ValueError("no times, expected a column or a period")
        return self


class ResampleEntry(Section):
    """Rows at an even `period` [s] (of the clock's ends if none); a longer step than `gap` [s] is a gap."""

    period: Seconds | None = None
    method: Literal["linear", "cubic", "previous", "mean"] = "linear"
    gap: Seconds | None = None


class DelayEntry(Section):
    """Bounds of a delay [s] that is sought; `shared`: signal of the first logger to column of the second."""

    low: Finite = Field(examples=[-0.02])
    high: Finite = Field(examples=[0.02])
    shared: Annotated[dict[str, ColumnName], OrEmpty] = {}

    @model_validator(mode="after")
    def _ordered(self) -> DelayEntry:
        if not self.low < self.high:
            raise ValueError(f"low is not below high, got {self.low!r} and {self.high!r}")
        return self


class MergeEntry(Section):
    """File of a second logger with `signals` of the case; its clock is `delay` [s] ahead of the first."""

    file: str = Field(examples=["load_cell.csv"])
    array: str | None = None
    time: TimeEntry | None = None
    signals: Annotated[list[str], Field(min_length=1, examples=[["force"]])]
    delay: Finite | DelayEntry = 0.0


class RecordingEntry(Section):
    """
    A file, or some rows of it.

    `columns` names those of signals that are elsewhere than in the others, `set` values that hold here alone.
    """

    file: str = Field(examples=["run.csv"])
    array: str | None = None
    rows: tuple[Annotated[Integer, Field(ge=0)], Integer] | None = None
    columns: Annotated[dict[str, ColumnName], OrEmpty] = {}
    merge: MergeEntry | None = None
    set: Annotated[dict[SignalKey, Finite], OrEmpty] = {}

    @model_validator(mode="after")
    def _ordered(self) -> RecordingEntry:
        if self.rows is not None and self.rows[1] <= self.rows[0]:
            raise ValueError(f"rows, got {list(self.rows)}, expected [first, end] with first below end")
        return self


def _recording(value: Any) -> Any:
    return {"file": value} if isinstance(value, str) else value


def _names_of_effects(value: Any) -> Any:
    return [value] if isinstance(value, str) and value != "all" else value


def _integer(value: Any) -> Any:
    """Take an integer for what it is; what is none is left to the choice of -1 and 1."""
    try:
        return integer_of(value)
    except ValueError:
        return value


class SignalEntry(Section):
    """
    A column as a signal: sign * scale * column in `unit`; or the rate of another signal.

    `bits` reads counts in two's complement. `wraps` follows a counter over the ends of its bits, or a column
    over those of the range that it names, in its own unit: 360, 4096.
    """

    column: ColumnName | None = None
    unit: str = "1"
    scale: Finite = 1.0
    sign: Annotated[Literal[-1, 1], BeforeValidator(_integer)] = 1
    offset: Finite = 0.0
    minus: str | None = None
    remove_mean: Boolean = False
    lowpass: Positive | None = None
    rate_of: str | None = None
    bits: Annotated[Integer, Field(ge=2, le=52)] | None = None
    wraps: Boolean | Positive = False

    @model_validator(mode="after")
    def _one(self) -> SignalEntry:
        if self.wraps is True and self.bits is None:
            raise ValueError("wraps, got no bits, expected how many the counter has, or a range like 360")
        if self.wraps is not True and self.wraps and self.bits is not None:
            raise ValueError("wraps, got a range and bits, expected wraps: true, or no bits")
        if (self.column is None) == (self.rate_of is None):
            raise ValueError("a signal has either 'column' or 'rate_of'")
        if self.scale == 0.0:
            raise ValueError("scale, got 0, expected another number")
        return self

    @property
    def range(self) -> float | None:
        """The range that the column wraps at, in its own unit; None if it does not."""
        if self.wraps is True and self.bits is not None:
            return 2.0**self.bits
        return float(self.wraps) if self.wraps else None


def _input(value: Any) -> Any:
    return {"signal": value} if isinstance(value, str) else value


class InputEntry(Section):
    """Measured signal that drives an FMU; `at`: the row at the start or at the end of the step."""

    signal: str = Field(examples=["force"])
    at: Literal["start", "end"] | None = None


class RefitEntry(Section):
    """Bounds of a parameter that may be wrong; `spread` is the deviation of a prior around its value."""

    low: Finite = Field(examples=[500.0])
    high: Finite = Field(examples=[2000.0])
    spread: Positive | None = None

    @model_validator(mode="after")
    def _ordered(self) -> RefitEntry:
        if not self.low < self.high:
            raise ValueError(f"low is not below high, got {self.low!r} and {self.high!r}")
        return self


class SplitEntry(Section):
    """Use of blocks in time order, or of whole recordings; `sealed` recordings beside blocks."""

    blocks: list[str] | None = None
    guard: Annotated[Finite, Field(ge=0.0)] = 0.2
    fit: list[str] = []
    select: list[str] = []
    sealed: list[str] = []

    @model_validator(mode="after")
    def _complete(self) -> SplitEntry:
        if self.blocks is None:
            missing = [part for part in PARTS if not getattr(self, part)]
            if missing:
                raise ValueError(
                    f"incomplete, got no {missing[0]}, "
                    "expected blocks, or recordings for fit, select and sealed"
                )
            return self
        wrong = sorted({b for b in self.blocks if b not in PARTS})
        missing = [p for p in PARTS if p not in self.blocks and not (p == "sealed" and self.sealed)]
        if wrong or missing:
            raise ValueError(f"blocks, got {wrong or 'no ' + missing[0]}, expected fit, select and sealed")
        return self


class ReplayEntry(Section):
    """How recordings are replayed."""

    oversample: Annotated[Integer, Field(ge=1, le=20)] = 1
    settle: Annotated[Finite, Field(ge=0.0)] = 0.0
    windows: Annotated[dict[str, Positive], OrEmpty] = {}
    cut: Annotated[Integer, Field(ge=0)] = 0
    decimate: Annotated[Integer, Field(ge=1, le=13)] = 1


_EXAMPLE_OF_SIGNALS = {"force": {"column": "F", "unit": "N"}}


class Case(Section):
    """A whole case."""

    name: Name = Field(examples=["my_case"])
    description: str = ""
    system: str | None = None
    variant: str | None = None
    fmus: Annotated[dict[InstanceName, FmuEntry], OrEmpty] = {}
    recordings: Annotated[
        dict[str, Annotated[RecordingEntry, BeforeValidator(_recording), OrText()]],
        Field(min_length=1, examples=[{"run": "run.csv"}]),
    ]
    time: TimeEntry = Field(examples=[{"column": "t", "unit": "s"}])
    resample: ResampleEntry | None = None
    signals: Annotated[dict[str, SignalEntry], Field(min_length=1, examples=[_EXAMPLE_OF_SIGNALS])]
    inputs: Annotated[
        dict[SignalKey, Annotated[InputEntry, BeforeValidator(_input), OrText()]],
        Field(min_length=1, examples=[{"spacecraft.f": "force"}]),
    ]
    compared: Annotated[
        dict[SignalKey, str], Field(min_length=1, examples=[{"spacecraft.s_des": "position"}])
    ]
    refit: Annotated[dict[SignalKey, RefitEntry], OrEmpty] = {}
    per_recording: list[SignalKey] = []
    set: Annotated[dict[SignalKey, GivenValue], OrEmpty] = {}
    starts: Annotated[dict[SignalKey, tuple[Finite, Finite]], OrEmpty] = {}
    slots: Annotated[
        dict[SignalKey, Annotated[Literal["all"] | list[str], BeforeValidator(_names_of_effects)]], OrEmpty
    ] = {}
    split: SplitEntry = Field(examples=[{"blocks": ["fit", "select", "sealed"]}])
    replay: ReplayEntry = ReplayEntry()

    @classmethod
    def stand_in(cls, key: str, data: Mapping[str, Any]) -> Any:
        return {"name": "case", "time": {"period": 1.0}}.get(key)

    @model_validator(mode="after")
    def _one_system(self) -> Case:
        if (self.system is None) == (not self.fmus):
            raise ValueError("a case has either 'system' or 'fmus'")
        return self


@dataclass(frozen=True)
class LoadedCase:
    """
    A case with the file it came from.

    `problems` are faults of the file; with any of them, `case` is what is left without them.
    """

    case: Case
    document: Document
    problems: list[Problem] = field(default_factory=list)

    def where(self, *place: str | int) -> str:
        """Name a place in the file."""
        return self.document.where(place)

    def file(self, entry: RecordingEntry | MergeEntry) -> Path:
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


def read_case(path: Path) -> LoadedCase:
    """
    Read a case as far as it is right; what is wrong is in `problems`.

    `path` is a YAML file, or the name of a case that is shipped.

    Raises:
        ConfigError: If too little is right to check the rest.
    """
    found = validate(Case, read_yaml(configuration(path)), "case")
    if found.model is None:
        raise ConfigError(found.problems)
    loaded = LoadedCase(found.model, found.document, found.problems)
    loaded.problems.extend(_names(loaded))
    return loaded


def load_case(path: Path) -> LoadedCase:
    """
    Read a case and check what can be checked without the system.

    Raises:
        ConfigError: With every fault of the file.
    """
    loaded = read_case(path)
    if loaded.problems:
        raise ConfigError(loaded.problems)
    return loaded


def _names(loaded: LoadedCase) -> list[Problem]:
    """Faults of names that must exist in the case itself."""
    case = loaded.case
    known = loaded.document.names_in("signals")
    free = loaded.document.names_in("refit")
    recordings = loaded.document.names_in("recordings")
    uses: list[tuple[Place, str]] = [(("inputs", key), e.signal) for key, e in case.inputs.items()]
    uses += [(("compared", key), name) for key, name in case.compared.items()]
    for name, s in case.signals.items():
        uses += [(("signals", name, k), v) for k, v in (("minus", s.minus), ("rate_of", s.rate_of)) if v]
    problems = [
        Problem("no such signal", where=loaded.where(*place), got=repr(name), expected=nearest(name, known))
        for place, name in uses
        if name not in known
    ]
    problems += [
        Problem(
            "no parameter to refit",
            where=loaded.where("per_recording", i),
            got=repr(name),
            expected=nearest(name, free),
        )
        for i, name in enumerate(case.per_recording)
        if name not in free
    ]
    with_column = [
        name for name in known if name not in case.signals or case.signals[name].column is not None
    ]
    problems += [
        Problem(
            "no signal with a column",
            where=loaded.where("recordings", recording, "columns", name),
            got=repr(name),
            expected=nearest(name, with_column),
        )
        for recording, entry in case.recordings.items()
        for name in entry.columns
        if name not in with_column
    ]
    problems += [
        Problem(
            "no signal with a column",
            where=loaded.where("recordings", recording, "merge", *place),
            got=repr(name),
            expected=nearest(name, with_column),
        )
        for recording, entry in case.recordings.items()
        for place, name in _of_merge(entry.merge)
        if name not in with_column
    ]
    problems += [
        Problem(
            "no such recording",
            where=loaded.where("split", part, i),
            got=repr(name),
            expected=nearest(name, recordings),
        )
        for part in PARTS
        for i, name in enumerate(getattr(case.split, part))
        if name not in recordings
    ]
    return problems + _uses(loaded)


def _of_merge(entry: MergeEntry | None) -> list[tuple[Place, str]]:
    """Signals that a second logger names, with their places below `merge`."""
    if entry is None:
        return []
    shared = entry.delay.shared if isinstance(entry.delay, DelayEntry) else {}
    return [
        *((("signals", i), name) for i, name in enumerate(entry.signals)),
        *((("delay", "shared", name), name) for name in shared),
    ]


def _uses(loaded: LoadedCase) -> list[Problem]:
    """Recordings that are used twice, not at all, or all sealed."""
    split, names = loaded.case.split, loaded.case.recordings
    used = [name for part in PARTS for name in getattr(split, part)]
    place = loaded.where("split")
    problems = [
        Problem(f"{name!r} is used {used.count(name)} times", where=place, expected="once")
        for name in dict.fromkeys(used)
        if used.count(name) > 1
    ]
    if split.blocks is None:
        idle = [name for name in names if name not in used]
        problems += [
            Problem(f"{name!r} is used for nothing", where=place, expected="a part for it") for name in idle
        ]
    elif set(names) <= set(split.sealed):
        problems.append(Problem("all recordings are sealed", where=place, expected="one to cut into blocks"))
    return problems

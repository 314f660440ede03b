"""Types of the fields of systems, cases and other files: what a scalar must be, and how it is read."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Annotated, Any

from pydantic import (
    AfterValidator,
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Field,
    PlainValidator,
    ValidatorFunctionWrapHandler,
    WrapValidator,
    model_validator,
)

from . import scalar
from .scalar import Plain, Setting, Value
from .signal_name import SignalName

LONGEST_NAME = 200  # bytes; file systems bear 255, and endings are added
_FORMULAS = ("=", "+", "-", "@")  # with what a cell of a formula begins
MOST_DELAY = 10**7  # ticks; each older value is kept in memory


class Section(BaseModel):
    """
    Base of all sections of a file: no unknown keys, no changes after reading.

    A key without a value (`parameters:`) or with `null` is a key that is not given.
    """

    model_config = ConfigDict(extra="forbid", frozen=True, populate_by_name=True)

    @model_validator(mode="before")
    @classmethod
    def _without_nothing(cls, data: Any) -> Any:
        if not isinstance(data, Mapping):
            return data
        names = {*cls.model_fields, *(f.alias for f in cls.model_fields.values() if f.alias)}
        return {key: value for key, value in data.items() if not (is_nothing(value) and key in names)}

    @classmethod
    def stand_in(cls, key: str, data: Mapping[str, Any]) -> Any:
        """
        Return what a required key is taken for while the rest of a wrong file is checked.

        None: without the key nothing can be said of the section.
        """
        return None


def is_nothing(value: Any) -> bool:
    """Whether a value is empty or `null`."""
    return value is None or (isinstance(value, Plain) and value.is_null)


def _or_empty(data: Any) -> Any:
    """Take nothing for an empty mapping, in a mapping of mappings too."""
    return {} if is_nothing(data) else data


def finite(value: float) -> float:
    """Return a finite number; ValueError for any other."""
    if not math.isfinite(value):
        raise ValueError("not a finite number")
    return value


def printable(text: str) -> str:
    """Return a text that fits a line of a message; ValueError for any other."""
    if len(text.encode(errors="replace")) > LONGEST_NAME:
        raise ValueError(f"a name of {len(text)} characters, expected at most {LONGEST_NAME} bytes")
    if not text.isprintable():
        raise ValueError("a name with control characters, expected printable ones")
    return text


def heading(text: str) -> str:
    """Return a name that no spreadsheet takes for a formula; ValueError for any other."""
    if text.startswith(_FORMULAS):
        expected = f"expected none with {text[0]!r} first"
        raise ValueError(f"a name that a spreadsheet takes for a formula, {expected}")
    return text


def file_name(text: str) -> str:
    """Return a name that a folder can have and that leads nowhere else; ValueError for any other."""
    if not text or text.strip(". ") == "" or any(c in "/\\" for c in text):
        raise ValueError("not a name of a folder, expected one without slashes")
    return heading(printable(text))


def instance_name(text: str) -> str:
    """Return a name that signals can be made of; ValueError for any other."""
    if not text or any(c.isspace() or c in ".<>" for c in text):
        raise ValueError("not a name without spaces, '.', '<' and '>'")
    return heading(printable(text))


def variable_name(text: str) -> str:
    """Return a name that a variable can have; ValueError for none."""
    if not text:
        raise ValueError("not a name of a variable, expected one character at least")
    return text


def _value(value: Any, inner: ValidatorFunctionWrapHandler) -> Any:
    """Keep a text as it is written: the type of the FMU's variable decides what it is."""
    if value is None:
        raise ValueError("no value, expected a number or a text ('' for an empty one)")
    if isinstance(value, dict | list):
        raise ValueError("not a value, expected a number or a text")
    return value if isinstance(value, Plain) else inner(value)


def _setting(value: Any) -> Any:
    """Refuse what is neither a value nor a list, nested or flat, of values."""
    if value is None:
        raise ValueError("no value, expected a number or a text ('' for an empty one)")
    if isinstance(value, dict):
        raise ValueError("not a value, expected a number, a text, or a list of them for an array")
    for part in value if isinstance(value, list) else ():
        _setting(part)
    return value


Number = Annotated[float, BeforeValidator(scalar.float_of)]
Finite = Annotated[Number, AfterValidator(finite)]
Positive = Annotated[Number, Field(gt=0.0)]
Seconds = Annotated[Finite, Field(gt=0.0)]
Integer = Annotated[int, BeforeValidator(scalar.integer_of)]
Ticks = Annotated[Integer, Field(ge=0, le=MOST_DELAY)]
Boolean = Annotated[bool, BeforeValidator(scalar.boolean_of)]
Name = Annotated[str, AfterValidator(file_name)]
InstanceName = Annotated[str, AfterValidator(instance_name)]
Signal = SignalName
SignalKey = Annotated[str, AfterValidator(SignalName)]
GivenValue = Annotated[Value, WrapValidator(_value)]
GivenSetting = Annotated[Setting, PlainValidator(_setting)]
VariableName = Annotated[str, AfterValidator(variable_name)]
ParameterValues = Annotated[dict[VariableName, GivenSetting], BeforeValidator(_or_empty)]
OrEmpty = BeforeValidator(_or_empty)

"""
Scalars as written: a text that is not in quotes keeps its characters, and who uses it decides its type.

A number is one of the core schema of YAML 1.2: `010` is ten, `1:30`, `1_000` and `yes` are texts.
Source   YAML 1.2.2, Sec. 10.3.
"""

from __future__ import annotations

import re
from datetime import datetime
from typing import Any

Value = bool | int | float | str
"""What a user gives for a variable; a `Plain` text where it was read from a file or an option."""

Setting = Value | list[Any]
"""Of an array: one value for all of its elements, or a list, nested or flat."""

_NULL = re.compile(r"null|Null|NULL|~")
_BOOLEAN = re.compile(r"true|True|TRUE|false|False|FALSE")
_INTEGER = re.compile(r"[-+]?[0-9]+|0o[0-7]+|0x[0-9a-fA-F]+")
_FLOAT = re.compile(r"[-+]?(\.[0-9]+|[0-9]+(\.[0-9]*)?)([eE][-+]?[0-9]+)?")
_INFINITE = re.compile(r"[-+]?\.(inf|Inf|INF)")
_NAN = re.compile(r"\.nan|\.NaN|\.NAN")
_DAY = r"(\d{4})-(\d\d?)-(\d\d?)"
_TIME = r"(?:[Tt]|[ \t]+)(\d\d?):(\d\d):(\d\d)(?:\.\d*)?(?:[ \t]*(?:Z|[-+]\d\d?(?::\d\d)?))?"
_DATE = re.compile(rf"{_DAY}(?:{_TIME})?", re.ASCII)
_MOST_DIGITS = 1000


class Plain(str):
    """Text of a scalar that is not in quotes."""

    @property
    def is_null(self) -> bool:
        """Whether it is `null` or `~`: YAML's word for nothing."""
        return _NULL.fullmatch(self) is not None

    @property
    def shown(self) -> str:
        """Text for a message: numbers and truths as they are, words in quotes."""
        try:
            number_of(self)
        except ValueError:
            return str(self) if _BOOLEAN.fullmatch(self) or self.is_null else repr(str(self))
        return str(self)


def boolean_of(value: object) -> bool:
    """
    Return the truth that a scalar is.

    Raises:
        ValueError: If it is none.
    """
    if isinstance(value, bool):
        return value
    if isinstance(value, str) and _BOOLEAN.fullmatch(value):
        return value.lower() == "true"
    raise ValueError("not true or false")


def number_of(value: object) -> int | float:
    """
    Return the number that a value is: an integer with all its digits, or a float.

    Raises:
        ValueError: If it is no number of the core schema; a Boolean is none.
    """
    if isinstance(value, int | float) and not isinstance(value, bool):
        return value
    if not isinstance(value, str):
        raise ValueError("not a number")
    if _INTEGER.fullmatch(value):
        return _integer(value)
    if _FLOAT.fullmatch(value):
        return float(value)
    if _INFINITE.fullmatch(value) or _NAN.fullmatch(value):
        return float(value.replace(".", "").lower())
    raise ValueError("not a number")


def integer_of(value: object) -> int:
    """
    Return the integer that a value is; `2.0` and `1e3` are integers too.

    Raises:
        ValueError: If it is none.
    """
    number = number_of(value)
    if isinstance(number, int):
        return number
    if not number.is_integer():
        raise ValueError("not an integer")
    return int(number)


def float_of(value: object) -> float:
    """
    Return a value as a float, infinite where it is beyond all floats.

    Raises:
        ValueError: If it is no number.
    """
    number = number_of(value)
    try:
        return float(number)
    except OverflowError:
        return float("inf") if number > 0 else float("-inf")


def is_impossible_date(text: str) -> bool:
    """Whether a text has the form of a date, with or without a time, but names none."""
    match = _DATE.fullmatch(text)
    if match is None:
        return False
    try:
        datetime(*(int(part or 0) for part in match.groups()))  # type: ignore[arg-type]
    except ValueError:
        return True
    return False


def _integer(text: str) -> int:
    if len(text) > _MOST_DIGITS:
        raise ValueError(f"a number of {len(text)} digits, expected at most {_MOST_DIGITS}")
    base = {"0o": 8, "0x": 16}.get(text[:2], 10)
    return int(text, base)

"""Arrays of FMI 3.0: each element is a variable with a name of its own, the array one block of values."""

from __future__ import annotations

import itertools
from typing import Any, NamedTuple

_NOT_EXCHANGED = {"Clock": "a clock", "Binary": "a binary"}


class Element(NamedTuple):
    """One element of an array: its name, its start value as written, and its number in row-major order."""

    name: str
    start: str
    number: int


def not_exchanged(v: Any) -> str:
    """What a variable (of FMPy) is that the master neither gets nor sets; empty for all others."""
    if v.causality == "independent":
        return "the time"
    if v.dimensions and v.type == "String":
        return "an array of strings"
    return _NOT_EXCHANGED.get(v.type, "")


def is_ticked(v: Any) -> bool:
    """Whether a variable (of FMPy) is a clock that the master would have to tick by the time."""
    return bool(v.type == "Clock" and v.causality == "input" and v.intervalVariability != "triggered")


def element_names(v: Any) -> list[str]:
    """Names of the elements of an array in row-major order; of a scalar its name."""
    if not v.dimensions:
        return [v.name]
    places = itertools.product(*(range(1, n + 1) for n in _shape(v)))
    return [f"{v.name}[{','.join(map(str, place))}]" for place in places]


def elements(v: Any) -> list[Element]:
    """Elements of an array; one start value is that of all, none is zero."""
    names = element_names(v)
    starts = (v.start or "").split()
    if len(starts) != len(names):
        starts = (starts[:1] or ["0"]) * len(names)
    return [Element(name, start, i) for i, (name, start) in enumerate(zip(names, starts, strict=True))]


def first_number(text: Any) -> float | None:
    """Give a number, of a list its first one."""
    return None if text is None else float(str(text).split()[0])


def _shape(v: Any) -> list[int]:
    """Fixed dimensions; one given by a structural parameter has that parameter's start value."""
    return [int(d.start if d.variable is None else d.variable.start) for d in v.dimensions]

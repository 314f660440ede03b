"""Values that a user gives for the variables of an FMU: what may be set, and to what."""

from __future__ import annotations

import math

from master.errors import expected

from .description import Description, Kind, Variable
from .value_types import RANGES, Value


def parse(variable: Variable, value: Value) -> float | str:
    """
    Turn a configured value into what the FMU takes; an enumeration takes its item's name.

    Raises:
        ValueError: With what is expected.
    """
    if variable.kind is Kind.STRING:
        return str(value)
    if isinstance(value, str):
        value = _from_text(variable, value)
    if variable.kind is Kind.BOOLEAN and value not in (0, 1):
        raise ValueError("expected true or false")
    if variable.items and value not in variable.items.values():
        raise ValueError(f"expected one of {', '.join(variable.items)}")
    if variable.kind is not Kind.REAL and not float(value).is_integer():
        raise ValueError("expected a whole number")
    _refuse_out_of_range(variable, float(value))
    return float(value)


def _from_text(variable: Variable, text: str) -> float:
    if variable.items:
        if text in variable.items:
            return variable.items[text]
        if not text.lstrip("-").isdigit():
            raise ValueError(expected(text, variable.items))
    if variable.kind is Kind.BOOLEAN and text in ("true", "false"):
        return float(text == "true")
    try:
        return float(text)
    except ValueError:
        raise ValueError("expected a number") from None


def _refuse_out_of_range(variable: Variable, value: float) -> None:
    if not math.isfinite(value):
        raise ValueError("expected a finite number")
    least, largest = RANGES.get(variable.value_type, (-math.inf, math.inf))
    if variable.minimum is not None:
        least = max(least, variable.minimum)
    if variable.maximum is not None:
        largest = min(largest, variable.maximum)
    if value < least:
        raise ValueError(f"expected at least {least:g}")
    if value > largest:
        raise ValueError(f"expected at most {largest:g}")


def settable(d: Description, name: str, key: str, value: Value, connected: set[str]) -> float | str:
    """
    Turn a value for variable `key` of instance `name` into what the FMU takes.

    Raises:
        ValueError: If there is no such variable, it cannot be set, is connected, or refuses the value.
    """
    variable = d.by_name.get(key)
    names = [
        v.name
        for v in d.variables
        if v.causality in ("parameter", "input") or v.initial in ("exact", "approx")
    ]
    if key in d.not_exchanged:
        raise ValueError(f"cannot be set, got {key!r} ({d.not_exchanged[key]}), {expected(key, names)}")
    if variable is None:
        raise ValueError(f"no such variable in {name} ({d.model_name}), got {key!r}, {expected(key, names)}")
    if variable.causality == "structuralParameter":
        problem = f"cannot be set, got {key!r} (a structural parameter, which keeps the FMU's value)"
        raise ValueError(f"{problem}, {expected(key, names)}")
    if key not in names or variable.variability == "constant":
        raise ValueError(f"cannot be set, got {key!r} (calculated by the FMU), {expected(key, names)}")
    if f"{name}.{key}" in connected:
        raise ValueError(f"has two sources, got a start value and a connection to {name}.{key}, expected one")
    try:
        return parse(variable, value)
    except ValueError as error:
        unit = "" if variable.unit_name == "1" else f" {variable.unit_name}"
        raise ValueError(f"value not allowed, got {value!r}{unit}, {error}") from None

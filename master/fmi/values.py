"""Values that a user gives for the variables of an FMU: what may be set, and to what."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator, Sequence

from master.errors import expected
from master.errors import shown as shown_value
from master.text.scalar import Setting, Value, boolean_of, number_of

from .description import Description, Kind, Variable
from .value_types import LONG, MOST_EXACT, TYPE_RANGES

_LARGEST = (2.0 - 2.0**-52) * 2.0**1023  # a double


def parse(variable: Variable, value: Value) -> float | str:
    """
    Turn a configured value into what the FMU takes: the variable's type decides what a text is.

    An enumeration takes its item's name or number, a String the text as it is written.

    Integers of 64 bits stay integers, so that no digit is lost; all other numbers are doubles.

    Raises:
        ValueError: With what is expected.
    """
    if variable.kind is Kind.STRING:
        return str(value)
    if variable.kind is Kind.BOOLEAN:
        return _truth(value)
    if isinstance(value, str) and value in variable.items:
        return float(variable.items[value]) if variable.value_type not in LONG else variable.items[value]
    number = _number(variable, value)
    if variable.items and number not in variable.items.values():
        raise ValueError(f"expected one of {', '.join(variable.items)}")
    if variable.kind is Kind.INTEGER:
        number = _integer(number)
    _refuse_out_of_range(variable, number)
    return number if variable.value_type in LONG else float(number)


def _truth(value: Value) -> float:
    try:
        return float(boolean_of(value))
    except ValueError:
        pass
    try:
        number = number_of(value)
    except ValueError:
        number = math.nan
    if number not in (0, 1):
        raise ValueError("expected true or false")
    return float(number)


def _number(variable: Variable, value: Value) -> int | float:
    try:
        return number_of(value)
    except ValueError as error:
        if variable.items:
            raise ValueError(expected(str(value), variable.items)) from None
        is_word = str(error) == "not a number"
        raise ValueError("expected a number" if is_word else f"expected a number, not {error}") from None


def _integer(number: float) -> int:
    """Take a number that is an integer, and surely the one that was meant."""
    if isinstance(number, int):
        return number
    if not number.is_integer():
        raise ValueError("expected an integer")
    if abs(number) > MOST_EXACT:
        raise ValueError("expected an integer with all of its digits, not a rounded number")
    return int(number)


def _refuse_out_of_range(variable: Variable, value: float) -> None:
    if isinstance(value, float) and not math.isfinite(value):
        raise ValueError("expected a finite number")
    least, largest = TYPE_RANGES.get(variable.value_type, (-_LARGEST, _LARGEST))
    if variable.minimum is not None:
        least = max(least, variable.minimum)
    if variable.maximum is not None:
        largest = min(largest, variable.maximum)
    if value < least:
        raise ValueError(f"expected at least {shown(least)}")
    if value > largest:
        raise ValueError(f"expected at most {shown(largest)}")


def shown(number: float) -> str:
    """Write a number for a message: integers with all digits."""
    return str(number) if isinstance(number, int) else f"{number:.9g}"


def settable(
    d: Description, name: str, key: str, value: Setting, connected: set[str]
) -> dict[str, float | str]:
    """
    Turn a value for variable `key` of instance `name` into what the FMU takes, by primary variables.

    An array takes a list, nested like its dimensions or flat in row-major order, or one value for all of
    its elements.

    Raises:
        ValueError: If there is no such variable, it cannot be set, is connected, or refuses the value.
    """
    targets = named_by(d, key)
    if not targets or not all(d.primary(v.name).is_settable for v in targets):
        _refuse(d, name, key)
    return dict(_settings(d, name, spread(d, key, value), connected))


def named_by(d: Description, key: str) -> Sequence[Variable]:
    """Variables that a name is for: the elements of an array, or one; none if there is no such name."""
    return (d.by_name[key],) if key in d.by_name else d.arrays.get(key, ())


def spread(d: Description, key: str, value: Setting) -> list[tuple[Variable, Value]]:
    """
    Pair the variables that a name is for with their values: those of a list, or one value for all.

    Raises:
        ValueError: If a list has not the shape of the array.
    """
    targets = named_by(d, key)
    values = _flat(value)
    if isinstance(value, list):
        _refuse_shape(d, key, value, targets)
    else:
        values = values * len(targets)
    return list(zip(targets, values, strict=True))


def _settings(
    d: Description, name: str, given: Sequence[tuple[Variable, Value]], connected: set[str]
) -> Iterator[tuple[str, float | str]]:
    for variable, value in given:
        primary = d.primary(variable.name)
        if f"{name}.{primary.name}" in connected:
            signal = f"{name}.{variable.name}"
            raise ValueError(f"has two sources, got a start value and a connection to {signal}, expected one")
        try:
            if primary is not variable:
                parse(variable, value)
            yield primary.name, parse(primary, value)
        except ValueError as error:
            unit = "" if variable.unit_name == "1" else f" {variable.unit_name}"
            element = "" if variable.array is None else f" for {variable.name}"
            raise ValueError(f"value not allowed, got {shown_value(value)}{unit}{element}, {error}") from None


def _refuse(d: Description, name: str, key: str) -> None:
    """Say why a variable cannot be set."""
    names = [v.name for v in d.variables if d.primary(v.name).is_settable]
    if key in d.not_exchanged:
        raise ValueError(f"cannot be set, got {key!r} ({d.not_exchanged[key]}), {expected(key, names)}")
    variable = d.by_name.get(key) or next(iter(d.arrays.get(key, ())), None)
    if variable is None:
        raise ValueError(f"no such variable in {name} ({d.model_name}), got {key!r}, {expected(key, names)}")
    raise ValueError(f"cannot be set, got {key!r} (calculated by the FMU), {expected(key, names)}")


def _refuse_shape(d: Description, key: str, value: list[object], targets: Sequence[Variable]) -> None:
    if key not in d.arrays:
        raise ValueError(f"value not allowed, got a list, expected one value for {key}")
    wanted = tuple(map(int, targets[-1].name.rpartition("[")[2][:-1].split(",")))
    got = _shape(value)
    if got not in (wanted, (len(targets),)):
        what = "a list whose parts differ" if got is None else f"a list of {_by(got)}"
        raise ValueError(f"value not allowed, got {what}, expected {_by(wanted)} values or one for all")


def _by(shape: Sequence[int]) -> str:
    return " x ".join(map(str, shape))


def _shape(value: object) -> tuple[int, ...] | None:
    """Lengths of nested lists along each dimension; None if they differ."""
    if not isinstance(value, list):
        return ()
    inner = {_shape(part) for part in value}
    if len(inner) > 1 or None in inner:
        return None
    return (len(value), *(inner.pop() or () if inner else ()))


def _flat(value: object) -> list[Value]:
    if isinstance(value, list):
        return [x for part in value for x in _flat(part)]
    return [value]  # type: ignore[list-item]  # the configuration holds nothing else


def start_notes(d: Description, given: Collection[str]) -> list[str]:
    """Say which start values of the FMU itself, not `given` others, break its own rules for its variables."""
    found = (_start_note(v) for v in d.variables if v.alias_of is None and v.name not in given)
    return [note for note in found if note is not None]


def _start_note(v: Variable) -> str | None:
    value = v.start_value
    if value is None or isinstance(value, str):
        return None
    try:
        parse(v, value)
    except ValueError as error:
        unit = "" if v.unit_name == "1" else f" {v.unit_name}"
        return f"{v.name}: the FMU's own start value is {shown(value)}{unit}, {error}; it is left as it is"
    return None


def alias_notes(d: Description) -> list[str]:
    """Say which variables share a value with one of another unit: each is taken in the unit that it has."""
    notes = []
    for v in d.variables:
        if v.alias_of is None:
            continue
        primary = d.by_name[v.alias_of]
        if v.unit is not None and primary.unit is not None and v.unit != primary.unit:
            units = f"{v.unit_name} and {primary.unit_name}"
            notes.append(f"{v.name}: shares a value with {primary.name}, got the units {units}, expected one")
    return notes

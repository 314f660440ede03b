"""Structural parameters of FMI 3.0: with other values of them, arrays have other sizes."""

from __future__ import annotations

from collections.abc import Mapping

from master.text.scalar import Setting

from .description import Description, Kind
from .description_reader import read_description
from .values import parse


def with_structure(d: Description, given: Mapping[str, Setting]) -> Description:
    """
    Return the description of an FMU with the values given for its structural parameters, if there are any.

    Values of other variables, and values that a parameter does not take, are left to whoever sets them.

    Raises:
        ConfigError: If arrays of these sizes are not possible.
    """
    structure: dict[str, int] = {}
    for key, value in given.items():
        variable = d.by_name.get(key)
        if variable is None or not variable.is_structural or variable.kind is not Kind.INTEGER:
            continue
        if isinstance(value, list):
            continue
        try:
            structure[d.primary(key).name] = int(parse(variable, value))
        except ValueError:
            continue
    return read_description(d.path, structure) if structure else d

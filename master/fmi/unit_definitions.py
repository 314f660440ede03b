"""Units of an FMU's variables: as its modelDescription.xml defines them, else as their names say."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any
from xml.etree import ElementTree as ET

from .unit_names import unit
from .units import Unit


def units_of(model: Any, root: ET.Element) -> dict[str, Unit]:
    """Unit of each variable that has one; `model` is FMPy's description, `root` the XML."""
    units = {u.name: _unit(u) for u in model.unitDefinitions}
    relative = _relative(root)
    found = {}
    for v in model.modelVariables:
        name = v.unit or (v.declaredType.unit if v.declaredType is not None else None)
        if name:
            unit = units.get(name) or _by_name(name)
            found[v.name] = replace(unit, offset=0.0) if v.name in relative else unit
    return found


def _relative(root: ET.Element) -> set[str]:
    """Variables that are differences, of temperatures for example: their unit's offset is not theirs."""

    def is_relative(e: ET.Element) -> bool:
        return e.get("relativeQuantity") in ("true", "1")

    types = {e.get("name") for e in root.iterfind("TypeDefinitions/*") if any(map(is_relative, (e, *e)))}
    return {
        e.get("name", "")
        for e in root.iterfind("ModelVariables/*")
        if any(is_relative(part) or part.get("declaredType") in types for part in (e, *e))
    }


def _by_name(name: str) -> Unit:
    """Take an undefined unit for what its name says, if it says anything."""
    try:
        return replace(unit(name), defined=False)
    except ValueError:
        return Unit(name, defined=False)


_EXPONENTS = ("kg", "m", "s", "A", "K", "mol", "cd", "rad")


def _unit(u: Any) -> Unit:
    base = u.baseUnit
    if base is None:
        return _by_name(u.name)
    exponents = {name: int(getattr(base, name) or 0) for name in _EXPONENTS}
    factor = 1.0 if base.factor is None else float(base.factor)
    offset = 0.0 if base.offset is None else float(base.offset)
    if not (math.isfinite(factor) and factor and math.isfinite(offset)):
        raise ValueError(f"unit {u.name} cannot be converted, got factor {factor:g} and offset {offset:g}")
    return Unit(u.name, {k: n for k, n in exponents.items() if n}, factor, offset)
